#include "slave.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "fmu.h"

enum { MESSAGE_SIZE = 2048 };

static const char ERROR_CATEGORY[] = "logStatusError";

static void drop(Object *object)
{
    if (object) py.Py_DecRef(object);
}

/* ---- Log ---- */

static bool is_told(const Slave *s, fmi2Status status, const char *category)
{
    if (status >= fmi2Error) return true;
    if (!s->is_logging || !s->categories) return s->is_logging;
    return py.PyMapping_HasKeyString(s->categories, category) || py.PyMapping_HasKeyString(s->categories, "logAll");
}

/* Messages are format strings to an importer, where # marks a variable (FMI 2.0.5, 2.1.5); UTF-8 is cut between characters. */
static void tell(const Slave *s, fmi2Status status, const char *category, const char *text)
{
    char message[MESSAGE_SIZE], *out = message, *const last = message + sizeof message - 3;
    for (; *text && out < last; text++) {
        if (*text == '#') *out++ = '#';
        *out++ = (char)(*text == '%' ? '_' : *text);
    }
    while (*text && out > message && (*text & 0xC0) == 0x80) text--, out--;
    *out = '\0';
    if (s->logger) s->logger(s->environment, s->name, status, category, message);
}

fmi2Status slave_refuse(const Slave *s, const char *format, ...)
{
    char text[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (char *c = text; *c; c++)
        if (*c & 0x80) *c = '?'; /* what others gave may not be UTF-8 */
    tell(s, fmi2Error, ERROR_CATEGORY, text);
    return fmi2Error;
}

/* Text as bytes, whatever is in it. */
static Object *utf8(Object *text)
{
    Object *const bytes = text ? py.PyUnicode_AsEncodedString(text, "utf-8", "backslashreplace") : NULL;
    drop(text);
    if (!bytes) py.PyErr_Clear();
    return bytes;
}

static const char *characters(Object *bytes) { return bytes ? py.PyBytes_AsString(bytes) : "?"; }

/* The exception that is raised, as a message. */
static fmi2Status tell_exception(Slave *s)
{
    Object *type, *value, *trace;
    py.PyErr_Fetch(&type, &value, &trace);
    py.PyErr_NormalizeException(&type, &value, &trace);
    if (py.PyErr_GivenExceptionMatches(type, *py.PyExc_KeyboardInterrupt)) {
        s->is_interrupted = true;
        slave_refuse(s, "The call was interrupted.");
    } else {
        Object *const name = utf8(py.PyObject_GetAttrString(type, "__name__"));
        Object *const text = utf8(value ? py.PyObject_Str(value) : NULL);
        py.PyErr_Clear();
        char message[MESSAGE_SIZE];
        snprintf(message, sizeof message, "%s: %s", characters(name), characters(text));
        tell(s, fmi2Error, ERROR_CATEGORY, message);
        drop(name);
        drop(text);
    }
    drop(type);
    drop(value);
    drop(trace);
    return fmi2Error;
}

static fmi2Status tell_one(const Slave *s, Object *message)
{
    Object *const number = py.PyObject_GetAttrString(message, "status");
    const fmi2Status status = (fmi2Status)(number ? py.PyLong_AsLong(number) : fmi2Error);
    Object *const category = utf8(py.PyObject_GetAttrString(message, "category"));
    Object *const text = utf8(py.PyObject_GetAttrString(message, "msg"));
    py.PyErr_Clear();
    if (is_told(s, status, characters(category))) tell(s, status, characters(category), characters(text));
    drop(number);
    drop(category);
    drop(text);
    return status;
}

static fmi2Status worse(fmi2Status a, fmi2Status b) { return a > b ? a : b; }

fmi2Status slave_status(Slave *s, fmi2Status status)
{
    if (py.PyErr_Occurred()) status = worse(status, tell_exception(s));
    Object *const queue = s->object ? py.PyObject_GetAttrString(s->object, "log_queue") : NULL;
    const Size n = queue ? py.PyList_Size(queue) : 0;
    for (Size k = 0; k < n; k++) {
        const fmi2Status one = tell_one(s, py.PyList_GetItem(queue, k));
        if (one >= fmi2Discard) status = worse(status, one);
    }
    if (n > 0) py.PyList_SetSlice(queue, 0, n, NULL);
    drop(queue);
    if (py.PyErr_Occurred()) status = worse(status, tell_exception(s));
    if (s->is_interrupted) py.PyErr_SetInterrupt(); /* a Control-C is the host's, not that of its function for messages */
    s->is_interrupted = false;
    return status;
}

/* ---- Life ---- */

/* The class; the folder is searched for modules only now. */
static Object *import_class(Object *folder)
{
    Object *const path = py.PySys_GetObject("path");
    if (!path || py.PyList_Insert(path, 0, folder)) return NULL;
    Object *type, *value, *trace, *const module = py.PyImport_ImportModule(SLAVE_MODULE);
    py.PyErr_Fetch(&type, &value, &trace);
    const Size place = py.PySequence_Index(path, folder);
    if (place >= 0) py.PySequence_DelItem(path, place);
    py.PyErr_Restore(type, value, trace);
    Object *const found = module ? py.PyObject_GetAttrString(module, SLAVE_CLASS) : NULL;
    drop(module);
    return found;
}

void slave_renew(Slave *s)
{
    Object *const none = py.Py_BuildValue("()");
    Object *const made = none ? py.PyObject_Call(s->type, none, s->arguments) : NULL;
    drop(none);
    if (!made) return;
    drop(s->object);
    s->object = made;
}

void slave_create(Slave *s, const char *resources, bool is_visible)
{
    Object *const folder = py.PyUnicode_DecodeFSDefault(resources);
    s->type = folder ? import_class(folder) : NULL;
    Object *const visible = s->type ? py.PyBool_FromLong(is_visible) : NULL;
    s->arguments = visible ? py.Py_BuildValue("{s:s,s:O,s:O}", "instance_name", s->name, "resources", folder, "visible",
                                              visible)
                           : NULL;
    if (s->arguments) slave_renew(s);
    drop(visible);
    drop(folder);
    slave_status(s, fmi2OK);
}

void slave_release(Slave *s)
{
    drop(s->strings);
    drop(s->categories);
    drop(s->object);
    drop(s->arguments);
    drop(s->type);
}

Object *slave_call(Slave *s, const char *method, Object *first, Object *second, Object *third)
{
    Object *const function = py.PyErr_Occurred() ? NULL : py.PyObject_GetAttrString(s->object, method);
    Object *const result = function ? py.PyObject_CallFunctionObjArgs(function, first, second, third, NULL) : NULL;
    drop(function);
    drop(first);
    drop(second);
    drop(third);
    return result;
}
