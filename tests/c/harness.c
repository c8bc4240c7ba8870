/* See harness.h. */
#define _POSIX_C_SOURCE 200809L
#include "harness.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Longer than any of the programs takes, under valgrind too. */
static const unsigned SECONDS = 300;

static const unsigned char SEAL_BYTE = 0xA5;

static int passed, failed, refusals;

void harness_begin(void)
{
    alarm(SECONDS);
}

int harness_end(void)
{
    printf("%d passed, %d failed\n", passed, failed);
    return failed == 0 && passed > 0 ? 0 : 1;
}

int harness_refusals(void)
{
    return refusals;
}

static void count(int holds)
{
    if (holds)
        ++passed;
    else
        ++failed;
}

int harness_expect(int holds, const char *text, const char *file, int line)
{
    count(holds);
    if (!holds)
        printf("%s:%d: not so: %s\n", file, line, text);
    return holds;
}

void harness_int(int64_t value, int64_t expected, const char *text, const char *file, int line)
{
    count(value == expected);
    if (value != expected)
        printf("%s:%d: %s is %lld, not %lld\n", file, line, text, (long long)value,
               (long long)expected);
}

void harness_real(double value, double expected, double tolerance, const char *text, const char *file,
                  int line)
{
    int holds = value == expected || fabs(value - expected) <= tolerance;

    count(holds);
    if (!holds)
        printf("%s:%d: %s is %.17g, not %.17g within %g\n", file, line, text, value, expected,
               tolerance);
}

void harness_text(const char *text, const char *expected, const char *name, const char *file, int line)
{
    int holds = text != NULL && strcmp(text, expected) == 0;

    count(holds);
    if (!holds)
        printf("%s:%d: %s is \"%s\", not \"%s\"\n", file, line, name, text ? text : "(NULL)", expected);
}

int harness_status(perion_status status, perion_status expected, const char *call, const char *file,
                   int line)
{
    count(status == expected);
    if (status != expected)
        printf("%s:%d: %s gives '%s', not '%s'; last error: %s\n", file, line, call,
               perion_status_string(status), perion_status_string(expected), perion_last_error());
    return status == expected;
}

/* Whether a text is "name: ... fragment ...", the name being that of the function called. */
static int says(const char *text, const char *call, const char *fragment)
{
    size_t name = strcspn(call, "(");

    return strncmp(text, call, name) == 0 && strncmp(text + name, ": ", 2) == 0
           && strstr(text + name, fragment) != NULL;
}

void harness_refused(perion_status status, perion_status expected, const char *fragment,
                     const char *call, const char *file, int line)
{
    int holds;

    ++refusals;
    if (!harness_status(status, expected, call, file, line))
        return;
    holds = says(perion_last_error(), call, fragment);
    count(holds);
    if (!holds)
        printf("%s:%d: %s says \"%s\", which does not name \"%s\"\n", file, line, call,
               perion_last_error(), fragment);
}

void harness_said(const char *fragment, const char *file, int line)
{
    int holds = strstr(perion_last_error(), fragment) != NULL;

    count(holds);
    if (!holds)
        printf("%s:%d: \"%s\" does not say \"%s\"\n", file, line, perion_last_error(), fragment);
}

void harness_seal(void *output, size_t bytes)
{
    memset(output, SEAL_BYTE, bytes);
}

void harness_sealed(const void *output, size_t bytes, const char *name, const char *file, int line)
{
    const unsigned char *content = output;
    size_t written = 0;

    for (size_t k = 0; k < bytes; ++k)
        written += content[k] != SEAL_BYTE;
    count(written == 0);
    if (written != 0)
        printf("%s:%d: %zu bytes of %s were written\n", file, line, written, name);
}
