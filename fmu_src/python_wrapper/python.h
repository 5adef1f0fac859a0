/* The interpreter that runs the slaves: that of the host where it has one, or else a libpython of the system.

   Its functions are looked up when the FMU is loaded, so the FMU is built without Python's headers and runs with any
   Python 3: all of them belong to the stable ABI. */
#ifndef PYTHON_H
#define PYTHON_H

#include <stdbool.h>
#include <stddef.h>

typedef struct Object Object;
typedef ptrdiff_t Size;

/* Result, name and arguments. */
#define PYTHON_FUNCTIONS(F)                                                                       \
    F(int, Py_IsInitialized, (void))                                                              \
    F(void, Py_InitializeEx, (int))                                                               \
    F(void *, PyEval_SaveThread, (void))                                                          \
    F(int, PyGILState_Ensure, (void))                                                             \
    F(void, PyGILState_Release, (int))                                                            \
    F(void, Py_IncRef, (Object *))                                                                \
    F(void, Py_DecRef, (Object *))                                                                \
    F(Object *, PyErr_Occurred, (void))                                                           \
    F(void, PyErr_Fetch, (Object **, Object **, Object **))                                       \
    F(void, PyErr_NormalizeException, (Object **, Object **, Object **))                          \
    F(void, PyErr_Restore, (Object *, Object *, Object *))                                        \
    F(void, PyErr_Clear, (void))                                                                  \
    F(int, PyErr_GivenExceptionMatches, (Object *, Object *))                                     \
    F(void, PyErr_SetInterrupt, (void))                                                           \
    F(Object *, PyImport_ImportModule, (const char *))                                            \
    F(Object *, PySys_GetObject, (const char *))                                                  \
    F(Object *, PyObject_GetAttrString, (Object *, const char *))                                 \
    F(Object *, PyObject_Call, (Object *, Object *, Object *))                                    \
    F(Object *, PyObject_CallFunctionObjArgs, (Object *, ...))                                    \
    F(Object *, PyObject_Str, (Object *))                                                         \
    F(int, PyObject_IsTrue, (Object *))                                                           \
    F(Object *, Py_BuildValue, (const char *, ...))                                               \
    F(Object *, PyBool_FromLong, (long))                                                          \
    F(Object *, PyFloat_FromDouble, (double))                                                     \
    F(double, PyFloat_AsDouble, (Object *))                                                       \
    F(Object *, PyLong_FromLong, (long))                                                          \
    F(Object *, PyLong_FromUnsignedLong, (unsigned long))                                         \
    F(long, PyLong_AsLong, (Object *))                                                            \
    F(Object *, PyUnicode_FromString, (const char *))                                             \
    F(Object *, PyUnicode_DecodeFSDefault, (const char *))                                        \
    F(Object *, PyUnicode_AsEncodedString, (Object *, const char *, const char *))                \
    F(Object *, PyBytes_FromStringAndSize, (const char *, Size))                                  \
    F(char *, PyBytes_AsString, (Object *))                                                       \
    F(Size, PyBytes_Size, (Object *))                                                             \
    F(Object *, PyList_New, (Size))                                                               \
    F(Size, PyList_Size, (Object *))                                                              \
    F(Object *, PyList_GetItem, (Object *, Size))                                                 \
    F(int, PyList_SetItem, (Object *, Size, Object *))                                            \
    F(int, PyList_SetSlice, (Object *, Size, Size, Object *))                                     \
    F(int, PyList_Insert, (Object *, Size, Object *))                                             \
    F(Size, PySequence_Index, (Object *, Object *))                                               \
    F(int, PySequence_DelItem, (Object *, Size))                                                  \
    F(int, PyMapping_HasKeyString, (Object *, const char *))                                     \
    F(int, PyMapping_SetItemString, (Object *, const char *, Object *))

typedef struct {
#define DECLARE(type, name, arguments) type(*name) arguments;
    PYTHON_FUNCTIONS(DECLARE)
#undef DECLARE
    Object **PyExc_KeyboardInterrupt;
} Python;

/* Its functions, once `python_start` has found them. */
extern Python py;

/* Find the interpreter, and begin it where the host has none; what is missing, or NULL. */
const char *python_start(void);

/* Hold the interpreter's lock; false when it has ended, or never began. */
bool python_enter(int *lock);
void python_leave(int lock);

#endif
