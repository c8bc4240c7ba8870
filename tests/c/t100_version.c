/* The library says what it is, and statuses have words. */
#include "harness.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

static void versions_agree_with_the_header(void)
{
    char text[64];

    EXPECT_INT(perion_version(),
               10000 * PERION_VERSION_MAJOR + 100 * PERION_VERSION_MINOR + PERION_VERSION_PATCH);
    EXPECT_INT(perion_abi_version(), PERION_ABI_VERSION);
    snprintf(text, sizeof text, "%d.%d.%d", PERION_VERSION_MAJOR, PERION_VERSION_MINOR,
             PERION_VERSION_PATCH);
    EXPECT_TEXT(perion_version_string(), text);
    EXPECT(strstr(perion_build_info(), text) != NULL);
    EXPECT(strchr(perion_build_info(), '\n') == NULL);
}

static void features_are_known_by_name(void)
{
    EXPECT(perion_has_feature("threads"));
    EXPECT(!perion_has_feature("ranks"));
    EXPECT(!perion_has_feature(""));
    EXPECT(!perion_has_feature("Threads"));
    EXPECT(!perion_has_feature("thread\xff"));
    EXPECT(!perion_has_feature(NULL));
}

static void every_status_has_words_of_its_own(void)
{
    static const perion_status others[] = {-1, PERION_ERROR_INTERNAL + 1, INT32_MIN, INT32_MAX};

    EXPECT_TEXT(perion_status_string(PERION_OK), "ok");
    for (perion_status status = PERION_OK; status <= PERION_ERROR_INTERNAL; ++status) {
        EXPECT(strcmp(perion_status_string(status), "unknown status") != 0);
        for (perion_status other = PERION_OK; other < status; ++other)
            EXPECT(strcmp(perion_status_string(status), perion_status_string(other)) != 0);
    }
    for (size_t k = 0; k < sizeof others / sizeof others[0]; ++k)
        EXPECT_TEXT(perion_status_string(others[k]), "unknown status");
}

static void a_success_leaves_the_last_error(void)
{
    int64_t count = 0;
    double corners[] = {0.0, 0.0, 2.0, 1.0};
    perion_points *points = NULL;

    EXPECT_TEXT(perion_last_error(), "");
    EXPECT_REFUSED(PERION_ERROR_NULL, "points", perion_points_count(NULL, &count));
    EXPECT_TEXT(perion_last_error(), "perion_points_count: argument 'points' is NULL");
    EXPECT_OK(perion_points_create_block(2, corners, corners + 2, 1.0, &points));
    EXPECT_TEXT(perion_last_error(), "perion_points_count: argument 'points' is NULL");
    EXPECT_OK(perion_points_destroy(&points));
}

int main(void)
{
    harness_begin();
    versions_agree_with_the_header();
    features_are_known_by_name();
    every_status_has_words_of_its_own();
    a_success_leaves_the_last_error();
    return harness_end();
}
