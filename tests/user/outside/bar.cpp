// The bar of the README as a C++ host writes it: handles are owned, failures are exceptions.
#include <perion.h>

#include <cstdio>
#include <memory>
#include <stdexcept>

static void check(perion_status status)
{
    if (status != PERION_OK) throw std::runtime_error(perion_last_error());
}

template <typename Handle, perion_status (*destroy)(Handle **)>
struct Destroy {
    void operator()(Handle *handle) const { destroy(&handle); }
};
using Points = std::unique_ptr<perion_points, Destroy<perion_points, perion_points_destroy>>;
using Model = std::unique_ptr<perion_model, Destroy<perion_model, perion_model_destroy>>;
using Simulation = std::unique_ptr<perion_simulation, Destroy<perion_simulation, perion_simulation_destroy>>;

static double force_at_the_end()
{
    const double lower[] = {0, 0, 0}, upper[] = {0.1, 0.02, 0.02}, slice[] = {0.002, 0.02, 0.02};

    perion_points *new_points = nullptr;
    check(perion_points_create_block(3, lower, upper, 0.002, &new_points));
    const Points points(new_points);
    check(perion_points_add_set_box(points.get(), "end", lower, slice));

    perion_model *new_model = nullptr;
    check(perion_model_create("bond_based", &new_model));
    const Model steel(new_model);
    check(perion_model_set(steel.get(), "density", 7800.0));
    check(perion_model_set(steel.get(), "youngs_modulus", 210e9));
    check(perion_model_set(steel.get(), "horizon", 3.015 * 0.002));

    perion_simulation *new_simulation = nullptr;
    check(perion_simulation_create(points.get(), steel.get(), &new_simulation));
    const Simulation bar(new_simulation);
    check(perion_simulation_prescribe(bar.get(), "end", PERION_QUANTITY_VELOCITY, 0, 1.0));
    double time_step = 0, force[3];
    check(perion_simulation_stable_time_step(bar.get(), &time_step));
    check(perion_simulation_step(bar.get(), 0.8 * time_step, 60));
    check(perion_simulation_sum(bar.get(), PERION_FIELD_REACTION, "end", force));
    return force[0];
}

int main()
{
    try {
        std::printf("%.1f N\n", force_at_the_end());
    } catch (const std::exception &failure) {
        std::fprintf(stderr, "%s\n", failure.what());
        return 1;
    }
    return 0;
}
