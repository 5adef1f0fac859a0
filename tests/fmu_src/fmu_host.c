/* A host without Python: loads the FMI 2.0 library that is named and does what standard input says, s(et) reference value,
   d(o step) time duration, g(et) reference, l(eave without freeing); what it gets is printed to the last digit:
   fmu_host LIBRARY TOKEN [RESOURCES] */
#include <stdio.h>

#include "fmi2FunctionTypes.h"
#include "fmi2TypesPlatform.h"

#if defined(_WIN32)
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void (*)(void))GetProcAddress((HMODULE)(library), name))
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
    char command;
    unsigned reference;
    double time, value;
    int status = 0;
    while (!status && scanf(" %c", &command) == 1) switch (command) {
        case 's':
            status = scanf("%u %lf", &reference, &value) != 2 || SetReal(c, &reference, 1, &value) != fmi2OK;
            break;
        case 'd':
            status = scanf("%lf %lf", &time, &value) != 2 || DoStep(c, time, value, fmi2True) != fmi2OK;
            break;
        case 'g':
            status = scanf("%u", &reference) != 1 || GetReal(c, &reference, 1, &value) != fmi2OK;
            printf("%.17g\n", value);
            fflush(stdout);
            break;
        case 'l':
            return 0;
        }
    FreeInstance(c);
    return status ? 5 : 0;
}
