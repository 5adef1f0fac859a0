/* Where the resources of an FMU are. */
#ifndef LOCATION_H
#define LOCATION_H

/* The folder that a URI names (FMI 2.0.5, 2.1.5; RFC 3986 and 8089), to be freed; or NULL with what is wrong. A path that
   an importer has not encoded is taken where it exists and the one by the standard does not. */
char *location_folder(const char *uri, const char **fault);

#endif
