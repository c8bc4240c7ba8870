/* Bad inputs to models. */
#include "bad.h"

static void formulations_are_known_by_name(void)
{
    perion_model *model;

    SEAL(model);
    EXPECT_REFUSED(NULLED, "formulation", perion_model_create(NULL, &model));
    EXPECT_REFUSED(NULLED, "model", perion_model_create("bond_based", NULL));
    EXPECT_REFUSED(ARGUMENT, "model", perion_model_create("bond_based", MISALIGNED(perion_model *)));
    EXPECT_REFUSED(ARGUMENT, "formulation", perion_model_create("bondbased", &model));
    EXPECT_SAID("did you mean 'bond_based'?");
    EXPECT_REFUSED(ARGUMENT, "formulation", perion_model_create("finite_elements", &model));
    EXPECT_REFUSED(ARGUMENT, "formulation", perion_model_create("", &model));
    EXPECT_REFUSED(ARGUMENT, "formulation", perion_model_create(latin1, &model));
    EXPECT_REFUSED(ARGUMENT, "formulation", perion_model_create(endless, &model));
    EXPECT_SEALED(model);
}

static void keys_are_known_by_name(perion_model *model)
{
    double value;

    SEAL(value);
    EXPECT_REFUSED(NULLED, "model", perion_model_set(NULL, "density", 1.0));
    EXPECT_REFUSED(NULLED, "key", perion_model_set(model, NULL, 1.0));
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_set(model, "yongs_modulus", 1.0));
    EXPECT_SAID("did you mean 'youngs_modulus'?");
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_set(model, "", 1.0));
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_set(model, latin1, 1.0));
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_set(model, endless, 1.0));
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_set(model, long_name, 1.0));
    EXPECT_REFUSED(NULLED, "model", perion_model_get(NULL, "density", &value));
    EXPECT_REFUSED(NULLED, "key", perion_model_get(model, NULL, &value));
    EXPECT_REFUSED(NULLED, "value", perion_model_get(model, "density", NULL));
    EXPECT_REFUSED(ARGUMENT, "value", perion_model_get(model, "density", MISALIGNED(double)));
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_get(model, "densty", &value));
    EXPECT_SAID("did you mean 'density'?");
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_get(model, "plane", &value));
    EXPECT_REFUSED(STATE, "bulk_modulus", perion_model_get(model, "bulk_modulus", &value));
    EXPECT_SEALED(value);
}

static void numbers_are_in_their_range(perion_model *model)
{
    static const char *const positive[] = {
        "density",          "horizon",   "youngs_modulus",  "bulk_modulus", "shear_modulus",
        "critical_stretch", "thickness", "critical_energy_release_rate",
    };
    static const double bad[] = {0.0, -0.0, -1.0, NAN, INFINITY, -INFINITY};
    static const double no_ratio[] = {-1.0, 0.5, 1.0, NAN, INFINITY};

    for (size_t key = 0; key < sizeof positive / sizeof positive[0]; ++key)
        for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k)
            EXPECT_REFUSED(ARGUMENT, positive[key], perion_model_set(model, positive[key], bad[k]));
    for (size_t k = 0; k < sizeof no_ratio / sizeof no_ratio[0]; ++k)
        EXPECT_REFUSED(ARGUMENT, "poissons_ratio",
                       perion_model_set(model, "poissons_ratio", no_ratio[k]));
    EXPECT_REFUSED(ARGUMENT, "lame_lambda", perion_model_set(model, "lame_lambda", NAN));
    EXPECT_REFUSED(ARGUMENT, "lame_lambda", perion_model_set(model, "lame_lambda", -INFINITY));
}

static void choices_are_known_by_name(perion_model *model)
{
    EXPECT_REFUSED(NULLED, "model", perion_model_choose(NULL, "plane", "stress"));
    EXPECT_REFUSED(NULLED, "key", perion_model_choose(model, NULL, "stress"));
    EXPECT_REFUSED(NULLED, "choice", perion_model_choose(model, "plane", NULL));
    EXPECT_REFUSED(ARGUMENT, "key", perion_model_choose(model, "plain", "stress"));
    EXPECT_SAID("did you mean 'plane'?");
    EXPECT_REFUSED(ARGUMENT, "choice", perion_model_choose(model, "plane", "strss"));
    EXPECT_SAID("did you mean 'stress'?");
    EXPECT_REFUSED(ARGUMENT, "choice", perion_model_choose(model, "plane", ""));
    EXPECT_REFUSED(ARGUMENT, "choice", perion_model_choose(model, "plane", "strain|stress"));
    EXPECT_REFUSED(ARGUMENT, "choice", perion_model_choose(model, "plane", latin1));
    EXPECT_REFUSED(ARGUMENT, "choice", perion_model_choose(model, "plane", endless));
    EXPECT_REFUSED(ARGUMENT, "density", perion_model_choose(model, "density", "2"));
    EXPECT_REFUSED(ARGUMENT, "plane", perion_model_set(model, "plane", 1.0));
    EXPECT_REFUSED(UNSUPPORTED, "influence", perion_model_choose(model, "influence", "constant"));
    EXPECT_REFUSED(ARGUMENT, "damage", perion_model_choose(model, "damage", "yes"));
}

static int never_asked(void *user, int64_t count, const double *F0, const double *F1,
                       const double *state0, double *state1, double *P, double *W)
{
    (void)user;
    (void)count;
    (void)F0;
    (void)F1;
    (void)state0;
    (void)state1;
    (void)P;
    (void)W;
    return 1;
}

static void laws_are_functions_with_a_state_that_can_be(perion_model *model)
{
    static const int64_t bad[] = {-1, 100001, INT64_MIN, INT64_MAX};
    perion_model *with_law = NULL;

    EXPECT_OK(perion_model_create("correspondence", &with_law));
    EXPECT_REFUSED(NULLED, "model", perion_model_set_material_function(NULL, 0, never_asked, NULL));
    EXPECT_REFUSED(NULLED, "function", perion_model_set_material_function(with_law, 0, NULL, NULL));
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k)
        EXPECT_REFUSED(ARGUMENT, "state_size",
                       perion_model_set_material_function(with_law, bad[k], never_asked, NULL));
    EXPECT_OK(perion_model_set_material_function(with_law, 100000, never_asked, NULL));
    EXPECT_REFUSED(UNSUPPORTED, "material",
                   perion_model_set_material_function(model, 0, never_asked, NULL));
    EXPECT_SAID("bond_based");
    EXPECT_OK(perion_model_destroy(&with_law));
}

static void only_models_are_used_as_models(void)
{
    perion_points *points = scene_points();
    perion_model *disguised = (perion_model *)(void *)points;
    int64_t count = 0;

    EXPECT_REFUSED(ARGUMENT, "model", perion_model_set(disguised, "density", 1.0));
    EXPECT_REFUSED(ARGUMENT, "model", perion_model_set(NO_HANDLE(perion_model), "density", 1.0));
    EXPECT_REFUSED(ARGUMENT, "model", perion_model_set(MISALIGNED(perion_model), "density", 1.0));
    EXPECT_REFUSED(ARGUMENT, "model", perion_model_destroy(&disguised));
    EXPECT((void *)disguised == (void *)points);
    EXPECT_OK(perion_points_count(points, &count));
    EXPECT_INT(count, SCENE_COUNT);
    EXPECT_OK(perion_points_destroy(&points));
}

void bad_model(void)
{
    static const char *const given[] = {"density", "horizon", "youngs_modulus", "critical_stretch"};
    static const double values[] = {1.0, 2.1, 1.0, 0.05};
    perion_model *model = scene_model();

    formulations_are_known_by_name();
    keys_are_known_by_name(model);
    numbers_are_in_their_range(model);
    choices_are_known_by_name(model);
    laws_are_functions_with_a_state_that_can_be(model);
    only_models_are_used_as_models();
    for (int k = 0; k < 4; ++k) {
        double value = 0.0;
        EXPECT_OK(perion_model_get(model, given[k], &value));
        EXPECT_REAL(value, values[k]);
    }
    EXPECT_OK(perion_model_destroy(&model));
}
