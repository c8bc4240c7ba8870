/*
 * A small harness: expectations that print where they fail, and a count at the end.
 *
 * A program begins with harness_begin(), states what it expects, and returns harness_end(). Nothing is
 * printed but failures and the last line, "N passed, N failed".
 */
#ifndef HARNESS_H
#define HARNESS_H

#include <perion.h>

#include <stddef.h>
#include <stdint.h>

/* A condition holds. */
#define EXPECT(condition) harness_expect((condition) ? 1 : 0, #condition, __FILE__, __LINE__)

/* Two integers are equal. */
#define EXPECT_INT(value, expected) \
    harness_int((int64_t)(value), (int64_t)(expected), #value, __FILE__, __LINE__)

/* Two numbers are equal; no tolerance. */
#define EXPECT_REAL(value, expected) harness_real((value), (expected), 0.0, #value, __FILE__, __LINE__)

/* Two numbers differ by no more than a tolerance. */
#define EXPECT_NEAR(value, expected, tolerance) \
    harness_real((value), (expected), (tolerance), #value, __FILE__, __LINE__)

/* Two texts are equal. */
#define EXPECT_TEXT(text, expected) harness_text((text), (expected), #text, __FILE__, __LINE__)

/* A call succeeds. */
#define EXPECT_OK(call) harness_status((call), PERION_OK, #call, __FILE__, __LINE__)

/* A call gives a status. */
#define EXPECT_STATUS(status, call) harness_status((call), (status), #call, __FILE__, __LINE__)

/* A call fails with a status and says so: its name first, then a text with a fragment in it, which is
 * the name of the argument at fault where there is one. */
#define EXPECT_REFUSED(status, fragment, call) \
    harness_refused((call), (status), (fragment), #call, __FILE__, __LINE__)

/* The last refusal of this thread has this in its text as well. */
#define EXPECT_SAID(fragment) harness_said((fragment), __FILE__, __LINE__)

/* An output that a call must not write: first one, then the call, then the other. */
#define SEAL(output) harness_seal(&(output), sizeof(output))
#define EXPECT_SEALED(output) harness_sealed(&(output), sizeof(output), #output, __FILE__, __LINE__)

/* Starts a program: one that hangs is ended by a signal. */
void harness_begin(void);

/* Prints the count and gives the exit code. */
int harness_end(void);

/* Number of refusals expected so far. */
int harness_refusals(void);

int harness_expect(int holds, const char *text, const char *file, int line);
void harness_int(int64_t value, int64_t expected, const char *text, const char *file, int line);
void harness_real(double value, double expected, double tolerance, const char *text, const char *file,
                  int line);
void harness_text(const char *text, const char *expected, const char *name, const char *file, int line);
int harness_status(perion_status status, perion_status expected, const char *call, const char *file,
                   int line);
void harness_refused(perion_status status, perion_status expected, const char *fragment,
                     const char *call, const char *file, int line);
void harness_said(const char *fragment, const char *file, int line);
void harness_seal(void *output, size_t bytes);
void harness_sealed(const void *output, size_t bytes, const char *name, const char *file, int line);

#endif
