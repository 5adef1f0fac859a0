#define _POSIX_C_SOURCE 200809L
#include "location.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static bool is_folder(const char *path)
{
    struct stat found;
    return path && stat(path, &found) == 0 && S_ISDIR(found.st_mode);
}

static int digit(char c) { return isdigit((unsigned char)c) ? c - '0' : tolower((unsigned char)c) - 'a' + 10; }

/* The text with each %XX as its byte; NULL where there is no such byte. */
static char *decoded(const char *text)
{
    char *result = malloc(strlen(text) + 1), *out = result;
    for (; result && *text; text++) {
        if (*text != '%') {
            *out++ = *text;
            continue;
        }
        if (!isxdigit((unsigned char)text[1]) || !isxdigit((unsigned char)text[2]) || !strncmp(text, "%00", 3)) {
            free(result);
            return NULL;
        }
        *out++ = (char)(16 * digit(text[1]) + digit(text[2]));
        text += 2;
    }
    if (result) *out = '\0';
    return result;
}

/* What follows scheme and host of a file URI, nothing where the host is another one; a path without a scheme as it is. */
static const char *path_of(const char *uri)
{
    static const char FILE_SCHEME[] = "file:", HERE[] = "//localhost/";
    if (strncasecmp(uri, FILE_SCHEME, sizeof FILE_SCHEME - 1)) return uri;
    uri += sizeof FILE_SCHEME - 1;
    if (!strncasecmp(uri, HERE, sizeof HERE - 1)) return uri + sizeof HERE - 2;
    if (strncmp(uri, "//", 2)) return uri;
    return uri[2] == '/' ? uri + 2 : "";
}

char *location_folder(const char *uri, const char **fault)
{
    *fault = "There is no location of the resources.";
    if (!uri) return NULL;
    const char *path = path_of(uri);
    *fault = "The resources are at no absolute path of this machine: give file:///folder/resources.";
    if (path[0] != '/') return NULL;
    char *folder = decoded(path);
    if (is_folder(folder)) return folder;
    free(folder);
    *fault = "The folder of the resources does not exist: unpack the whole FMU.";
    return is_folder(path) ? strdup(path) : NULL;
}
