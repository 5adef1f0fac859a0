#include "internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 512 };

const char *write_shortest(char text[32], double number)
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, 32, "%.*g", digits, number);
        if (strtod(text, NULL) == number) break;
    }
    char *mark = text + strspn(text, "-0123456789"); /* the host's locale may have another one, of many bytes */
    const size_t size = strcspn(mark, "0123456789abcdefghijklmnopqrstuvwxyz");
    if (size) {
        memmove(mark + 1, mark + size, strlen(mark + size) + 1);
        *mark = '.';
    }
    return text;
}

/* LogCategories of the model description, by status; the first stands for all of them. */
static const char *const CATEGORIES[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                         "logStatusFatal"};
enum { N_CATEGORIES = sizeof CATEGORIES / sizeof *CATEGORIES, ALL = (1 << N_CATEGORIES) - 1 };

/* Bytes of the character of UTF-8 at c; 0 if it is cut or none. */
static int character_size(const char *c)
{
    const unsigned char first = (unsigned char)*c;
    const int size = first < 0x80 ? 1 : first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
    for (int k = 1; k < size; k++)
        if (((unsigned char)c[k] & 0xC0) != 0x80) return 0;
    return size;
}

/* Errors are always told. A message may be a format string to an importer, so it holds no percent sign; # is the
   standards' escape character and is doubled; what is not UTF-8 is left out. */
static void vsay(const Instance *i, Status status, const char *format, va_list arguments)
{
    if (!(i->logged & 1u << status) && status != ERROR) return;
    char text[MESSAGE_SIZE], message[2 * MESSAGE_SIZE], *end = message;
    vsnprintf(text, sizeof text, format, arguments);
    for (const char *c = text; *c;) {
        const int size = character_size(c);
        if (*c == '#') *end++ = '#';
        for (int k = 0; k < size; k++) *end++ = c[k] == '%' ? '_' : c[k];
        c += size ? size : 1;
    }
    *end = '\0';
    i->logger(i, status, CATEGORIES[status], message);
}

void instance_say(const Instance *i, Status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsay(i, status, format, arguments);
    va_end(arguments);
}

Status instance_refuse(const Instance *i, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsay(i, ERROR, format, arguments);
    va_end(arguments);
    return ERROR;
}

bool instance_is_missing(const Instance *i, size_t n, const void *pointer)
{
    if (n > 0 && !pointer) instance_refuse(i, "A null pointer was given for %zu values.", n);
    return n > 0 && !pointer;
}

/* ---- Life ---- */

Instance *instance_create(const char *name, const char *token, bool is_model_exchange, bool is_logging, Logger *logger,
                          void (*callback)(void), void *environment)
{
    const bool is_named = name && *name, is_ours = token && !strcmp(token, MODEL_TOKEN);
    const size_t length = is_named ? strlen(name) : 0;
    Instance *i = calloc(1, sizeof *i);
    if (i) i->name = malloc(length + 1);
    if (!i || !i->name) {
        free(i);
        return NULL;
    }
    if (is_named) memcpy(i->name, name, length);
    i->name[length] = '\0';
    i->logger = logger;
    i->callback = callback;
    i->environment = environment;
    i->logged = is_logging ? ALL : 0;
    i->now.is_model_exchange = is_model_exchange;
    instance_reset(i);
    if (!is_named) instance_refuse(i, "An instance needs a name.");
    else if (!is_ours)
        instance_refuse(i, "The token %.80s is not that of this FMU, %s: read modelDescription.xml again.",
                        token ? token : "(null)", MODEL_TOKEN);
    else if (is_model_exchange && !HAS_MODEL_EXCHANGE) instance_refuse(i, "The FMU has no model exchange.");
    else return i;
    instance_free(i);
    return NULL;
}

void instance_free(Instance *i)
{
    if (!i) return;
    free(i->name);
    free(i);
}

void instance_touch(Instance *i)
{
    i->is_stale[RATES] = i->is_stale[RESULTS] = i->is_stale[LATER] = i->is_slope_stale[0] = i->is_slope_stale[1] = true;
}

Status instance_reset(Instance *i)
{
    i->now.mode = INSTANTIATED;
    for (int v = 0; v < N_VARIABLES; v++) i->now.values[v] = model_variables[v].start;
    memset(i->now.is_refused, 0, sizeof i->now.is_refused);
    memset(i->now.is_held, 0, sizeof i->now.is_held);
    memset(i->now.memory, 0, sizeof i->now.memory);
    i->stop_time = INFINITY;
    i->is_step_refused = false;
    instance_touch(i);
    return OK;
}

Status instance_initialize(Instance *i)
{
    instance_enter(i, i->now.is_model_exchange ? EVENT : STEP);
    return OK;
}

void instance_enter(Instance *i, Mode mode)
{
    if (HAS_STEP_EVENTS && mode == CONTINUOUS) instance_update(i, RESULTS); /* the last moment of the event */
    if (HAS_STEP_EVENTS && mode == EVENT) instance_touch(i);
    i->now.mode = mode;
}

bool instance_needs_event(Instance *i)
{
    return HAS_STEP_EVENTS && instance_update(i, RESULTS) == OK && i->is_event_due;
}

bool instance_allows(const Instance *i, const char *function, unsigned modes)
{
    if (!i) return false;
    if (!(i->now.mode & modes)) {
        const char *const names[] = {"Instantiated", "Initialization Mode", "Step Mode", "Event Mode",
                                     "Continuous-Time Mode", "Terminated"};
        int place = 0;
        while (i->now.mode >> place > 1) place++;
        instance_refuse(i, "%s must not be called in the state %s.", function, names[place]);
        return false;
    }
    return true;
}

Status instance_set_logging(Instance *i, bool is_on, bool is_exclusive, size_t n, const char *const categories[])
{
    if (instance_is_missing(i, n, categories)) return ERROR;
    unsigned named = n ? 0 : ALL;
    for (size_t k = 0; k < n; k++) {
        unsigned category = 0;
        while (category < N_CATEGORIES && !(categories[k] && !strcmp(categories[k], CATEGORIES[category]))) category++;
        if (category == N_CATEGORIES)
            return instance_refuse(i, "There is no log category %.80s.", categories[k] ? categories[k] : "(null)");
        named |= category ? 1u << category : ALL;
    }
    const unsigned others = is_exclusive ? 0 : i->logged & ~named;
    i->logged = others | (is_on ? named : 0);
    return OK;
}

/* ---- Time ---- */

double instance_time(const Instance *i) { return i->now.values[TIME_REFERENCE]; }

Status instance_set_times(Instance *i, double start, bool has_stop, double stop)
{
    if (!isfinite(start) || (has_stop && !(isfinite(stop) && stop >= start)))
        return instance_refuse(i, "An experiment from %s s to %s s cannot be run.", SHORTEST(start),
                               SHORTEST(has_stop ? stop : start));
    i->now.values[TIME_REFERENCE] = start;
    i->stop_time = has_stop ? stop : INFINITY;
    return OK;
}

Status instance_set_time(Instance *i, double time)
{
    if (!isfinite(time))
        return instance_refuse(i, "The time was given as %s s, allowed is a finite one.", SHORTEST(time));
    i->now.values[TIME_REFERENCE] = time;
    return OK;
}
