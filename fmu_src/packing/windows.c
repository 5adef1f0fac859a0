/* What the headers of Zig's C library for Windows ask for beyond the library that Windows has (ucrtbase.dll). With these
   functions here an FMU needs no other one; Zig would first compile its own, 444 files and minutes of work. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

int vsnprintf(char *restrict text, size_t size, const char *restrict format, va_list values)
{
    return __stdio_common_vsprintf(_CRT_INTERNAL_PRINTF_STANDARD_SNPRINTF_BEHAVIOR, text, size, format, NULL, values);
}

int snprintf(char *restrict text, size_t size, const char *restrict format, ...)
{
    va_list values;
    va_start(values, format);
    const int length = vsnprintf(text, size, format, values);
    va_end(values);
    return length;
}

/* Functions with the attribute constructor, between -1 and a null; the linker lists them. */
extern void (*__CTOR_LIST__[])(void);

/* What Windows calls as it loads and unloads the library, in the place of a C runtime's. */
int DllMainCRTStartup(void *library, unsigned reason, void *reserved)
{
    enum { LOADED = 1 };
    (void)library;
    (void)reserved;
    if (reason == LOADED)
        for (int k = 1; __CTOR_LIST__[k]; k++) __CTOR_LIST__[k]();
    return 1;
}

/* isfinite asks it */
int __fpclassify(double x) { return __builtin_fpclassify(FP_NAN, FP_INFINITE, FP_NORMAL, FP_SUBNORMAL, FP_ZERO, x); }
