/* A host without Python: loads the FMI 2.0 library that is named, flies two seconds with moving controls and prints the
   states to the last digit:  flight_host LIBRARY TOKEN */
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

enum { STATES = 12, CONTROLS = 4, FIRST_CONTROL = 24, STEPS = 100 };

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
    fmi2Component c = Instantiate("host", fmi2CoSimulation, argv[2], "", &callbacks, fmi2False, fmi2False);
    if (!c) return 4;
    fmi2ValueReference states[STATES], controls[CONTROLS];
    double x[STATES], u[CONTROLS];
    for (unsigned k = 0; k < STATES; k++) states[k] = k;
    for (unsigned k = 0; k < CONTROLS; k++) controls[k] = FIRST_CONTROL + k;
    SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0);
    EnterInitializationMode(c);
    ExitInitializationMode(c);
    for (int n = 0; n < STEPS; n++) {
        for (int k = 0; k < CONTROLS; k++) u[k] = 0.05 * (k + 1) * ((n / 10 + k) % 3 - 1) + (k == 3 ? 0.5 : 0);
        if (SetReal(c, controls, CONTROLS, u) > fmi2Warning || DoStep(c, n * 0.02, 0.02, fmi2True) != fmi2OK) return 5;
    }
    if (GetReal(c, states, STATES, x) != fmi2OK) return 6;
    FreeInstance(c);
    for (int k = 0; k < STATES; k++) printf("%.17g\n", x[k]);
    return 0;
}
