/* A host without Python: loads the FMI 2.0 library that is named and does what the lines of standard input say, s(et)
   reference value, d(o step) time duration, g(et) reference, l(eave without freeing); what it gets is printed to the last
   digit:
   fmu_host LIBRARY TOKEN [RESOURCES] */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"
#include "fmi2TypesPlatform.h"

#if defined(_WIN32)
#include <windows.h>
#include <corecrt_startup.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void (*)(void))GetProcAddress((HMODULE)(library), name))

/* Zig would first compile a C library for minutes. With that of Windows and fmu_src/packing/windows.c alone a program has
   to begin by itself. */
#define main host_main
int main(int argc, char **argv);
void start(void)
{
    _configure_narrow_argv(_crt_argv_unexpanded_arguments);
    exit(main(__argc, __argv));
}
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) ((void (*)(void))dlsym(library, name))
#endif

#define LOAD(name)                                                  \
    fmi2##name##TYPE *const name = (fmi2##name##TYPE *)FIND(library, "fmi2" #name); \
    if (!name) return 3

int main(int argc, char **argv)
{
    if (argc < 3) return 1;
    void *library = OPEN(argv[1]);
    if (!library) return 2;
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(SetReal);
    LOAD(GetReal);
    LOAD(DoStep);
    LOAD(FreeInstance);
    const fmi2CallbackFunctions callbacks = {NULL, NULL, NULL, NULL, NULL};
    fmi2Component c = Instantiate("host", fmi2CoSimulation, argv[2], argc > 3 ? argv[3] : "", &callbacks, fmi2False, fmi2False);
    if (!c) return 4;
    SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0);
    EnterInitializationMode(c);
    ExitInitializationMode(c);
    char line[200], answer[40], *rest;
    int status = 0;
    while (!status && fgets(line, sizeof line, stdin)) {
        const double first = strtod(line + 1, &rest), value = strtod(rest, &rest);
        const unsigned reference = (unsigned)first;
        double got;
        switch (line[0]) {
        case 's':
            status = SetReal(c, &reference, 1, &value) != fmi2OK;
            break;
        case 'd':
            status = DoStep(c, first, value, fmi2True) != fmi2OK;
            break;
        case 'g':
            status = GetReal(c, &reference, 1, &got) != fmi2OK;
            snprintf(answer, sizeof answer, "%.17g", got);
            puts(answer);
            fflush(stdout);
            break;
        case 'l':
            return 0;
        default:
            status = 1;
        }
    }
    FreeInstance(c);
    return status ? 5 : 0;
}
