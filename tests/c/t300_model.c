/* Models: keys and choices, and the lists that input decks and user interfaces are made from. */
#include "harness.h"

#include <stdlib.h>
#include <string.h>

static void formulations_are_listed(void)
{
    int64_t count = perion_formulation_count();

    EXPECT(count >= 1);
    for (int64_t k = 0; k < count; ++k) {
        perion_model *model = NULL;
        EXPECT(strlen(perion_formulation_description(k)) > 0);
        EXPECT_OK(perion_model_create(perion_formulation_name(k), &model));
        EXPECT_OK(perion_model_destroy(&model));
    }
    EXPECT_TEXT(perion_formulation_name(0), "bond_based");
}

static void lists_end(void)
{
    const int64_t outside[] = {-1, INT64_MIN, INT64_MAX, perion_key_count(), 1LL << 40};

    for (size_t k = 0; k < sizeof outside / sizeof outside[0]; ++k) {
        EXPECT(perion_key_name(outside[k]) == NULL);
        EXPECT(perion_key_description(outside[k]) == NULL);
        EXPECT(perion_key_default(outside[k]) == NULL);
        EXPECT(perion_key_choices(outside[k]) == NULL);
        EXPECT(perion_formulation_name(outside[k]) == NULL);
        EXPECT(perion_formulation_description(outside[k]) == NULL);
    }
}

/* A number, or one of the choices, goes in; what is listed as default comes out. */
static void try_key(int64_t index)
{
    const char *name = perion_key_name(index), *choices = perion_key_choices(index);
    const char *first = perion_key_default(index);
    perion_model *model = NULL;
    double value = 0.0;

    const char *formulation = "";

    EXPECT(strlen(name) > 0 && strlen(perion_key_description(index)) > 0);
    EXPECT(choices[0] == '\0' || strstr(choices, first) != NULL);
    /* With the first formulation that takes it; each takes some. */
    for (int64_t k = 0; k < perion_formulation_count(); ++k) {
        perion_status status;
        char choice[64] = {0};

        formulation = perion_formulation_name(k);
        EXPECT_OK(perion_model_create(formulation, &model));
        memcpy(choice, choices, strcspn(choices, "|"));
        if (choices[0] == '\0') {
            status = perion_model_set(model, name, first[0] != '\0' ? strtod(first, NULL) : 0.25);
        } else {
            status = perion_model_choose(model, name, choice);
        }
        EXPECT_OK(perion_model_destroy(&model));
        if (status != PERION_ERROR_UNSUPPORTED) {
            EXPECT_INT(status, PERION_OK);
            break;
        }
        formulation = "";
    }
    EXPECT_OK(perion_model_create(formulation, &model));
    if (choices[0] == '\0') {
        double given = first[0] != '\0' ? strtod(first, NULL) : 0.25;
        if (first[0] != '\0') {
            EXPECT_OK(perion_model_get(model, name, &value));
            EXPECT_REAL(value, given);
        } else {
            EXPECT_REFUSED(PERION_ERROR_STATE, name, perion_model_get(model, name, &value));
        }
        EXPECT_OK(perion_model_set(model, name, given));
        EXPECT_OK(perion_model_get(model, name, &value));
        EXPECT_REAL(value, given);
    } else {
        EXPECT_OK(perion_model_choose(model, name, strrchr(choices, '|') + 1));
    }
    EXPECT_OK(perion_model_destroy(&model));
}

static void every_key_can_be_used_as_it_is_listed(void)
{
    EXPECT(perion_key_count() >= 13);
    for (int64_t k = 0; k < perion_key_count(); ++k)
        try_key(k);
}

static void the_last_value_counts(void)
{
    perion_model *model = NULL;
    double value = 0.0;

    EXPECT_OK(perion_model_create("bond_based", &model));
    EXPECT_OK(perion_model_set(model, "density", 1.0));
    EXPECT_OK(perion_model_set(model, "density", 2.0));
    EXPECT_OK(perion_model_get(model, "density", &value));
    EXPECT_REAL(value, 2.0);
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT(model == NULL);
    EXPECT_OK(perion_model_destroy(&model));
    EXPECT_OK(perion_model_destroy(NULL));
}

int main(void)
{
    harness_begin();
    formulations_are_listed();
    lists_end();
    every_key_can_be_used_as_it_is_listed();
    the_last_value_counts();
    return harness_end();
}
