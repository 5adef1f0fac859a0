#define _GNU_SOURCE /* RTLD_DEFAULT */
#include "python.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>

Python py;

enum { OLDEST = 11, NEWEST = 30 };

#ifdef __APPLE__
static const char LIBRARY[] = "libpython3.%d.dylib";
#else
static const char LIBRARY[] = "libpython3.%d.so.1.0";
#endif

/* Its modules in C find its functions in the process, so they are made known there. */
static void *open_library(void)
{
    for (int minor = NEWEST; minor >= OLDEST; minor--) {
        char name[32];
        snprintf(name, sizeof name, LIBRARY, minor);
        void *library = dlopen(name, RTLD_NOW | RTLD_GLOBAL);
        if (library) return library;
    }
    return NULL;
}

static const char *find(void)
{
    static char missing[96];
    void *library = RTLD_DEFAULT;
    if (!dlsym(library, "Py_IsInitialized")) library = open_library();
    if (!dlsym(library ? library : RTLD_DEFAULT, "Py_IsInitialized"))
        return "The FMU runs in Python, and there is none: use a host with Python, or install libpython 3.11 or newer.";
#define LOOK_UP(type, name, arguments)                                                             \
    if (!(*(void **)&py.name = dlsym(library, #name))) {                                           \
        snprintf(missing, sizeof missing, "The Python of this process has no %s: use Python 3.11 or newer.", #name); \
        return missing;                                                                            \
    }
    PYTHON_FUNCTIONS(LOOK_UP)
    LOOK_UP(Object *, PyExc_KeyboardInterrupt, )
#undef LOOK_UP
    return NULL;
}

const char *python_start(void)
{
    static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;
    static bool is_found;
    const char *fault = NULL;
    pthread_mutex_lock(&one_at_a_time);
    if (!is_found) fault = find();
    is_found = !fault;
    if (is_found && !py.Py_IsInitialized()) {
        py.Py_InitializeEx(0);  /* signals stay the host's */
        py.PyEval_SaveThread(); /* any thread may take the lock; the interpreter ends with the process */
    }
    pthread_mutex_unlock(&one_at_a_time);
    return fault;
}

bool python_enter(int *lock)
{
    if (!py.Py_IsInitialized || !py.Py_IsInitialized()) return false;
    *lock = py.PyGILState_Ensure();
    return true;
}

void python_leave(int lock) { py.PyGILState_Release(lock); }
