/*
 * Perion: the peridynamics core.
 *
 * Every call that can fail returns a perion_status; perion_last_error() gives the calling thread's last
 * failure as text: function, argument, value, limit. A refused call changes nothing, and an output is
 * written only on success. A pointer is required (ERROR_NULL) unless its name ends in _or_null, it is a
 * callback, or the count beside it is 0. A call that makes an object writes its handle without a look at
 * what stood there: destroy that first.
 *
 * Units are the host's own, consistent ones. Text is UTF-8 of at most 4096 bytes. Indices and axes start
 * at 0; vectors are stored point after point.
 *
 * Distinct handles may be used from different threads at once; one handle by one thread at a time, but
 * calls that take a const handle may overlap. A violation is ERROR_STATE. Do not fork between create and
 * destroy. Callbacks run on the calling thread, in the host's floating-point environment; they must
 * return: no exception, longjmp or exit. Any call may also give ERROR_MEMORY, ERROR_POISONED after an
 * internal error, and ERROR_STATE where the threads cannot be started.
 *
 * Generated from src/ffi by cbindgen; do not edit. `make bindings` writes it anew.
 */

#ifndef PERION_H
#define PERION_H

#include <stdbool.h>
#include <stdint.h>

/**
 * Major number of this header's version.
 */
#define PERION_VERSION_MAJOR 0

/**
 * Minor number of this header's version.
 */
#define PERION_VERSION_MINOR 1

/**
 * Patch number of this header's version.
 */
#define PERION_VERSION_PATCH 0

/**
 * Version of this header's binary interface; a library with another one cannot be used with it.
 */
#define PERION_ABI_VERSION 0

/**
 * Room that the name of any set needs, the NUL at its end included.
 */
#define PERION_NAME_CAPACITY 256

/**
 * A formulation with its material and options.
 */
typedef struct perion_model perion_model;

/**
 * A cloud of points with volumes, optional horizons and named sets.
 */
typedef struct perion_points perion_points;

/**
 * A body of points that moves under a model.
 */
typedef struct perion_simulation perion_simulation;

/**
 * What every fallible call returns: PERION_OK, or the kind of failure; perion_last_error() has the
 * text. Since 0.1.
 */
typedef int32_t perion_status;

/**
 * A law of the host's own: fills P (first Piola-Kirchhoff stress) and W (stored energy per reference volume) for `count`
 * deformation gradients F1, and state1, which is the material's only when a step is completed or committed. F0 and
 * state0 are those of the last committed state: F0 = I and state0 = 0 at first. Tensors are [count][D][D], row after row,
 * with F_ij = dx_i/dX_j and D the dimension of the points; states [count][state_size]; state1 comes as state0. Must
 * give the same for the same. Runs on the calling thread, one at a time, with the host's floating-point environment;
 * must not throw or jump out, and may not call anything on the simulation. A result other than 0 stops the call
 * (ERROR_INTERRUPTED).
 */
typedef int (*perion_material_function)(void *user,
                                        int64_t count,
                                        const double *F0,
                                        const double *F1,
                                        const double *state0,
                                        double *state1,
                                        double *P,
                                        double *W);

/**
 * What a condition prescribes.
 */
typedef int32_t perion_quantity;

/**
 * A function that the host prescribes: fills values[count] at `time` for the points of its set, whose
 * reference positions [count][dimension] come in the set's order. Runs on the calling thread, with the
 * host's floating-point environment; must not throw or jump out, and may not call anything on the
 * simulation. A result other than 0 stops the run (ERROR_INTERRUPTED).
 */
typedef int (*perion_function)(void *user,
                               double time,
                               int64_t count,
                               const double *reference_positions,
                               double *values);

/**
 * A quantity that every point has. Vectors have one number an axis, tensors one a pair of axes, row after
 * row (component i, j of a point is its number dimension * i + j, counted from 0); all others have one.
 * Numbers that are missing are kept for fields to come.
 */
typedef int32_t perion_field;

/**
 * What a field is differentiated by, and with which bonds (Bergel and Li, Table 1). With xi the bond in the
 * reference body, eta the same deformed and sums over the family, K = sum w xi xi^T V,
 * N = sum w eta xi^T V and M = sum w eta eta^T V.
 */
typedef int32_t perion_operator;

/**
 * A field in the library's own memory and inner order. Component c of the host's point p is
 * data[place * point_stride + c * component_stride], place = slot ? slot[p] : p. Valid until returned.
 * Let perion_view_init set struct_size.
 */
typedef struct perion_view {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * the values
     */
    double *data;
    /**
     * inner place of each of the host's points; NULL when the orders are the same
     */
    const int64_t *slot;
    /**
     * number of points
     */
    int64_t count;
    /**
     * numbers a point
     */
    int64_t components;
    /**
     * doubles from one point to the next
     */
    int64_t point_stride;
    /**
     * doubles from one component to the next
     */
    int64_t component_stride;
    /**
     * which borrowing this is
     */
    int64_t generation;
} perion_view;

/**
 * Told after each step of step and advance, each load step of solve, and each step of the motion of relax: `done` of
 * `total` of this run, and the time. It runs on the calling
 * thread with the host's floating-point environment; it must not throw or jump out. It may make const
 * calls on its simulation, write_vtk and write_series among them; others give ERROR_STATE. A result
 * other than 0 stops the run (ERROR_INTERRUPTED).
 */
typedef int (*perion_progress)(void *user, int64_t done, int64_t total, double time);

/**
 * How much a message matters.
 */
typedef int32_t perion_log_level;

/**
 * Takes messages of the library, on the calling thread; the text lives for the call. It must not
 * throw, jump out, or call anything on the simulation.
 */
typedef void (*perion_log)(void *user, perion_log_level level, const char *message);

/**
 * What a run has done: advance, solve or relax. Members that do not belong to it are 0. Let perion_report_init set
 * struct_size.
 */
typedef struct perion_report {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * steps completed; of solve load steps, of relax 1
     */
    int64_t steps;
    /**
     * how often the stable step was found
     */
    int64_t estimates;
    /**
     * the smallest time step, 0 when none was made
     */
    double smallest_time_step;
    /**
     * the largest time step
     */
    double largest_time_step;
    /**
     * the stable step as it was last found
     */
    double stable_time_step;
    /**
     * time of the last completed step
     */
    double time;
    /**
     * of solve: load steps that failed and were cut
     */
    int64_t cuts;
    /**
     * of solve: linear systems solved; of relax: its steps
     */
    int64_t iterations;
    /**
     * of solve and relax: forces evaluated
     */
    int64_t evaluations;
    /**
     * of solve and relax: bonds broken
     */
    int64_t broken_bonds;
    /**
     * of solve and relax: share of the way to the conditions that was gone, 1 when complete
     */
    double share;
    /**
     * of solve and relax: relative residual of the last iteration
     */
    double residual;
    /**
     * of solve and relax: elastic energy at the end of a run that succeeded
     */
    double elastic;
    /**
     * of solve and relax: work of loads and constraints
     */
    double external_work;
    /**
     * given by the host: room for relative residuals, one an iteration, and how many numbers it has; NULL for none
     */
    double *residuals_or_null;
    /**
     * see above
     */
    int64_t residual_capacity;
    /**
     * how many residuals there are; the first residual_capacity are written
     */
    int64_t residual_count;
    /**
     * given by the host: room for as many energies of the motion of relax, over the largest that it had, one a step; NULL
     * for none
     */
    double *energies_or_null;
} perion_report;

/**
 * How perion_simulation_advance chooses its steps; a member that is 0 stands for its default. Let
 * perion_advance_options_init set struct_size.
 */
typedef struct perion_advance_options {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * time step over the stable one, at most 1; default 0.8
     */
    double safety;
    /**
     * steps are never longer; default: no limit
     */
    double largest_time_step;
    /**
     * steps after which the stable one is found anew, at the cost of ten forces; after a quarter of them when bonds
     * have broken; default 100
     */
    int64_t interval;
} perion_advance_options;

/**
 * A method for linear systems.
 */
typedef int32_t perion_krylov;

/**
 * What linear systems are preconditioned by.
 */
typedef int32_t perion_preconditioner;

/**
 * How perion_simulation_solve looks for equilibrium; a member that is 0 stands for its default. Let
 * perion_solve_options_init set struct_size.
 */
typedef struct perion_solve_options {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * time at the end, along which tables and functions are asked; 0: the current time
     */
    double time_end;
    /**
     * forces out of balance over loads or reactions, whichever are larger (2-norms); default 1e-8
     */
    double tolerance;
    /**
     * load steps, equally long; cut where one fails, as long again where they are easy; default 1
     */
    int64_t load_steps;
    /**
     * share of the way that a load step has at least; default 1e-3
     */
    double smallest_load_step;
    /**
     * linear systems that a load step may take, each time bonds have broken; default 25
     */
    int64_t iterations;
    /**
     * products of the stiffness that a linear system may take, each of one force; default 2000
     */
    int64_t products;
    /**
     * how often bonds may break within a load step; default 200
     */
    int64_t breaks;
    /**
     * a method for linear systems
     */
    perion_krylov krylov;
    /**
     * what they are preconditioned by
     */
    perion_preconditioner preconditioner;
} perion_solve_options;

/**
 * How perion_simulation_relax looks for equilibrium; a member that is 0 stands for its default. Let
 * perion_relax_options_init set struct_size.
 */
typedef struct perion_relax_options {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * forces out of balance over loads or reactions, whichever are larger (2-norms); default 1e-6
     */
    double tolerance;
    /**
     * energy of the damped motion over the largest that it had; default 1e-9
     */
    double energy_tolerance;
    /**
     * steps that it may take, each time bonds have broken; default 100000
     */
    int64_t steps;
    /**
     * steps over which prescribed displacements are applied; default 100
     */
    int64_t ramp;
    /**
     * how often bonds may break; default 200
     */
    int64_t breaks;
} perion_relax_options;

/**
 * The energy of a simulation, in units of energy. Let perion_energy_init set struct_size.
 */
typedef struct perion_energy {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * sum 1/2 rho V v^2
     */
    double kinetic;
    /**
     * sum V W, what the bonds hold
     */
    double elastic;
    /**
     * what broken bonds held, and the work of plastic flow
     */
    double dissipated;
    /**
     * work of body forces, and of what holds prescribed points
     */
    double external_work;
    /**
     * kinetic + elastic + dissipated that neither external work nor the start accounts for. Velocity
     * Verlet lets it swing by about (omega dt)^2/8 of the energy; growing above that, energy comes out of
     * nothing. Steps that the host commits itself are not in it: their work is not known
     */
    double closure_error;
    /**
     * part of dissipated that plastic flow took
     */
    double plastic;
} perion_energy;

/**
 * What to look at before trusting a result. Let perion_health_init set struct_size.
 */
typedef struct perion_health {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * points without a neighbour in the reference configuration
     */
    int64_t isolated_points;
    /**
     * the first of them, -1 for none
     */
    int64_t first_isolated_point;
    /**
     * points that had neighbours and have lost all bonds
     */
    int64_t detached_points;
    /**
     * the first of them, -1 for none
     */
    int64_t first_detached_point;
    /**
     * bonds in all
     */
    int64_t bonds;
    /**
     * bonds broken
     */
    int64_t broken_bonds;
    /**
     * last time step over the stable one as it was last found; 0 before the first step. Near 1 the limit is near
     */
    double time_step_ratio;
    /**
     * smallest stretch of a bond that is not broken, 0 when none is compressed; below about -0.3 bonds
     * are on their way to collapse, and the stable step promises nothing
     */
    double smallest_stretch;
    /**
     * points with bonds whose families do not span the body (a plate one point thick, a chain, a family
     * thinned by broken bonds) or do not bear the gradient_order asked for: the material is asked in the
     * directions spanned alone, without stress across, and the gradient is of first order
     */
    int64_t degenerate_points;
    /**
     * the first of them, -1 for none
     */
    int64_t first_degenerate_point;
    /**
     * the stable step as it was last found; 0 before that. Where the host's own steps are known to be below it no more is looked for:
     * then an estimate, no lower than these
     */
    double stable_time_step;
    /**
     * 1 where it was found from forces that have a potential, and is stable for small motions about the state it
     * was found at; 0 where it is an estimate
     */
    int64_t stable_step_is_guaranteed;
} perion_health;

/**
 * Heap bytes that a simulation holds. Let perion_memory_init set struct_size.
 */
typedef struct perion_memory {
    /**
     * Bytes of the caller's struct.
     */
    int64_t struct_size;
    /**
     * points, their order, sets, places and materials
     */
    int64_t points;
    /**
     * bonds, their state and when they break; 0 before set-up has ended
     */
    int64_t bonds;
    /**
     * displacement, velocity, acceleration, forces, dissipated energy
     */
    int64_t state;
    /**
     * all of it
     */
    int64_t total;
} perion_memory;

/**
 * The call did what it says.
 */
#define PERION_OK 0

/**
 * A pointer that must not be NULL is NULL.
 */
#define PERION_ERROR_NULL 1

/**
 * A value, a count, a name or a combination of them is not allowed; nothing was changed.
 */
#define PERION_ERROR_ARGUMENT 2

/**
 * The call does not fit the state of the handle, or the handle is in use by another call.
 */
#define PERION_ERROR_STATE 3

/**
 * The memory that the call needs could not be had; the handle is unchanged.
 */
#define PERION_ERROR_MEMORY 4

/**
 * A file could not be read or written.
 */
#define PERION_ERROR_IO 5

/**
 * A file was read, but what is in it is not understood.
 */
#define PERION_ERROR_FORMAT 6

/**
 * A computed quantity is not finite; the text names the point.
 */
#define PERION_ERROR_NUMERIC 7

/**
 * An iteration did not converge; the state is that of the last completed step.
 */
#define PERION_ERROR_CONVERGENCE 8

/**
 * A callback asked to stop.
 */
#define PERION_ERROR_INTERRUPTED 9

/**
 * The request makes sense but is not offered; the text says what is.
 */
#define PERION_ERROR_UNSUPPORTED 10

/**
 * An earlier internal error left the handle unusable: get and destroy still work.
 */
#define PERION_ERROR_POISONED 11

/**
 * A defect of the library: please report the text.
 */
#define PERION_ERROR_INTERNAL 12

/**
 * Displacement, a length.
 */
#define PERION_QUANTITY_DISPLACEMENT 1

/**
 * Velocity.
 */
#define PERION_QUANTITY_VELOCITY 2

/**
 * Force per reference volume.
 */
#define PERION_QUANTITY_BODY_FORCE 3

/**
 * Force per reference area of the surface along a set of points, the outermost layer; a dead load.
 */
#define PERION_QUANTITY_TRACTION 4

/**
 * Position in the reference configuration, a length; a vector.
 */
#define PERION_FIELD_REFERENCE_POSITION 1

/**
 * Current position, a length; a vector. Can be set.
 */
#define PERION_FIELD_POSITION 2

/**
 * Displacement, a length; a vector. Can be set.
 */
#define PERION_FIELD_DISPLACEMENT 3

/**
 * Velocity; a vector. Can be set.
 */
#define PERION_FIELD_VELOCITY 4

/**
 * Acceleration; a vector, 0 where displacement or velocity is prescribed.
 */
#define PERION_FIELD_ACCELERATION 5

/**
 * Internal force per reference volume; a vector.
 */
#define PERION_FIELD_INTERNAL_FORCE 6

/**
 * Body force per reference volume; a vector. get gives the host's own and that of conditions together,
 * set replaces the host's own alone: what was got is not what to set.
 */
#define PERION_FIELD_BODY_FORCE 7

/**
 * Force that holds prescribed components; a vector, 0 elsewhere.
 */
#define PERION_FIELD_REACTION 8

/**
 * Volume; in 2D area times thickness.
 */
#define PERION_FIELD_VOLUME 9

/**
 * Mass per volume.
 */
#define PERION_FIELD_DENSITY 10

/**
 * Share of the volume of a point's family that broken bonds have cost it, 0 to 1.
 */
#define PERION_FIELD_DAMAGE 11

/**
 * Energy of the bonds per reference volume.
 */
#define PERION_FIELD_STRAIN_ENERGY_DENSITY 12

/**
 * Energy per reference volume of the penalty on what the material does not see.
 */
#define PERION_FIELD_STABILIZATION_ENERGY_DENSITY 13

/**
 * Energy that broken bonds held and that plastic flow took, per reference volume.
 */
#define PERION_FIELD_DISSIPATED_ENERGY_DENSITY 14

/**
 * Deformation gradient F_ij = dx_i/dX_j; a tensor. Where the bonds of a point do not span the body, what they
 * leave out turns with them and thins freely.
 */
#define PERION_FIELD_DEFORMATION_GRADIENT 15

/**
 * Green-Lagrange strain (F^T F - I)/2; a tensor.
 */
#define PERION_FIELD_STRAIN 16

/**
 * Plastic strain of j2_plastic in the rotated frame of the law; a tensor, 0 for what does not flow. Of
 * ordinary_state_based, in the reference frame, what its plastic extensions would pull on a unit of area, over 2 mu:
 * too small where a surface or a crack cuts the family.
 */
#define PERION_FIELD_PLASTIC_STRAIN 17

/**
 * First Piola-Kirchhoff stress P_ij, the force in axis i on the reference area across axis j; a tensor.
 * correspondence: that of the material at F, without the penalty of the stabilised forms.
 * bond_associated_quadrature: the mean over the bonds. The others: the virial or areal stress
 * 1/2 sum (t_ij - t_ji) (x) xi V_j, too small where a surface or a crack cuts the family.
 */
#define PERION_FIELD_FIRST_PIOLA_STRESS 18

/**
 * Cauchy stress P F^T/J of the two above, J with the thickness in plane stress; a tensor. Symmetric where P
 * is of a material at F, else as nearly as bonds deform alike.
 */
#define PERION_FIELD_CAUCHY_STRESS 19

/**
 * Cauchy stress across a 2D body: 0 in plane stress. ERROR_UNSUPPORTED in 3D.
 */
#define PERION_FIELD_STRESS_33 20

/**
 * Von Mises stress of the Cauchy stress, with that across a 2D body.
 */
#define PERION_FIELD_VON_MISES_STRESS 21

/**
 * Change of volume per volume, in 2D of area per area: theta of ordinary_state_based (where it flows that of what is
 * elastic, which is the same while the family is whole) and madenci_oterkus, for the others det F - 1.
 */
#define PERION_FIELD_DILATATION 22

/**
 * Number of points within the point's own horizon.
 */
#define PERION_FIELD_NEIGHBOR_COUNT 23

/**
 * Time step by the usual formula, a time; not a bound.
 */
#define PERION_FIELD_TIME_STEP_ESTIMATE 24

/**
 * Shape tensor K = sum w xi xi^T V over a point's family (Bergel and Li), xi the bond in the reference
 * configuration and w its weight, broken bonds left out; a tensor.
 */
#define PERION_FIELD_SHAPE_TENSOR 25

/**
 * N = sum w eta xi^T V with eta the bond as it is now: F = N K^-1; a tensor.
 */
#define PERION_FIELD_MIXED_SHAPE_TENSOR 26

/**
 * M = sum w eta eta^T V; a tensor.
 */
#define PERION_FIELD_DEFORMED_SHAPE_TENSOR 27

/**
 * Equivalent plastic strain: its increments are sqrt(2/3) of the size of those of the plastic strain. Of
 * ordinary_state_based: plastic work over the yield stress.
 */
#define PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN 28

/**
 * By reference coordinates with bonds of the reference body: h = K^-1 xi.
 */
#define PERION_OPERATOR_REFERENCE_UNDEFORMED 1

/**
 * By reference coordinates with deformed bonds: h = N^-1 eta.
 */
#define PERION_OPERATOR_REFERENCE_DEFORMED 2

/**
 * By current coordinates with bonds of the reference body: h = N^-T xi.
 */
#define PERION_OPERATOR_CURRENT_UNDEFORMED 3

/**
 * By current coordinates with deformed bonds: h = M^-1 eta.
 */
#define PERION_OPERATOR_CURRENT_DEFORMED 4

/**
 * Something the host should look at.
 */
#define PERION_LOG_LEVEL_WARNING 1

/**
 * Something that helps to follow what happens.
 */
#define PERION_LOG_LEVEL_INFORMATION 2

/**
 * The default: conjugate gradients where forces have a potential, minimal residuals where the stiffness then turns out
 * to have a direction without resistance; else generalised minimal residuals.
 */
#define PERION_KRYLOV_AUTOMATIC 0

/**
 * Conjugate gradients: for a stiffness that is symmetric and positive.
 */
#define PERION_KRYLOV_CONJUGATE_GRADIENTS 1

/**
 * Minimal residuals: for one that is symmetric.
 */
#define PERION_KRYLOV_MINIMAL_RESIDUALS 2

/**
 * Generalised minimal residuals, started again after 40 products: for any.
 */
#define PERION_KRYLOV_GENERALISED_MINIMAL_RESIDUALS 3

/**
 * The default: a cycle over several levels of a stiffness of springs. Few iterations at any size of the body.
 */
#define PERION_PRECONDITIONER_GLOBAL 0

/**
 * The stiffness of each point alone: no set-up, many iterations.
 */
#define PERION_PRECONDITIONER_BLOCK_DIAGONAL 1

/**
 * Nothing.
 */
#define PERION_PRECONDITIONER_NONE 2

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Version of the library in use: 10000 major + 100 minor + patch.
 */
int32_t perion_version(void);

/**
 * Version of the binary interface of the library in use.
 */
int32_t perion_abi_version(void);

/**
 * Version of the library in use as text, "0.1.0". The text lives as long as the library.
 */
const char *perion_version_string(void);

/**
 * How the library was built, in a line. The text lives as long as the library.
 */
const char *perion_build_info(void);

/**
 * Whether the library has an optional feature. Known are "threads" (it has) and "ranks" (not yet);
 * false for NULL and anything else.
 */
bool perion_has_feature(const char *name);

/**
 * Two or three words for a status number, "unknown status" for a number that is none. The text is
 * static: valid for ever, not to be freed. Since 0.1.
 */
const char *perion_status_string(perion_status status);

/**
 * The last failure on the calling thread as one line of text: function, argument, value, limit,
 * what to do; "" when nothing has failed. A later success leaves it. The buffer belongs to the
 * thread: the next failure overwrites it, the end of the thread ends it. Since 0.1.
 */
const char *perion_last_error(void);

/**
 * Makes points from the host's arrays, which are copied.
 *
 * coordinates: lengths, `dimension` of them a point, `stride` doubles from one point to the next.
 * volumes: `count` of them; in 2D areas. Points may come in any order.
 *
 * ERROR_ARGUMENT: dimension not 2 or 3, count below 1, stride below dimension, a coordinate that is
 * not finite, a volume that is not positive, two points in one place. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_points_create(int32_t dimension,
                                   int64_t count,
                                   const double *coordinates,
                                   int64_t stride,
                                   const double *volumes,
                                   struct perion_points **points);

/**
 * Makes a block of points: a lattice of cells of edge `spacing` between the corners `lower` and
 * `upper` (`dimension` lengths each), a point in the middle of each cell, x fastest. Counts per axis
 * are rounded; each point has the volume spacing^dimension.
 *
 * ERROR_ARGUMENT: dimension not 2 or 3, limits not finite or upside down, spacing not positive or
 * too large, too many points. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_points_create_block(int32_t dimension,
                                         const double *lower,
                                         const double *upper,
                                         double spacing,
                                         struct perion_points **points);

/**
 * Reads points from a file, whose name tells what it is: .inp (Abaqus), .msh (Gmsh 4.1 or 2.2, text or
 * binary), .vtu (VTK), anything else text.
 *
 * Text: a point a line, "x y z volume", "x y z block volume", or "x y area" in 2D, with blanks or commas between;
 * #, ! and % begin comments. A first line may name the columns, in any order and with others beside
 * them. Blocks become sets block_1 and so on.
 *
 * Mesh: each cell of the highest dimension becomes a point in its centroid with its volume (plane cells: its
 * area), in the file's order. Groups of such cells (*ELSET, physical groups) become sets; a group of nodes
 * (*NSET), or of cells of lower dimension such as the faces of a boundary, becomes the set of the
 * points whose cells have one of its nodes. A name that other points have already gets "_2"; a group
 * without points is left out. perion_points_get_set_name lists what came of them.
 *
 * A .vtu without cells, or with vertices only, is a cloud with a point array "volume"; it is 2D if all z are
 * 0. An integer array "block" gives sets.
 *
 * ERROR_IO: it cannot be read. ERROR_FORMAT: it is not what it should be; the text says file and line (where
 * a line is at fault), what was expected and what was found. ERROR_UNSUPPORTED: what points cannot express, such as includes and
 * instances of Abaqus, or curved shells. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_points_read(const char *path,
                                 struct perion_points **points);

/**
 * Gives each point its own horizon (a length, `count` of them) in place of the model's.
 *
 * ERROR_ARGUMENT: count is not the number of points, a horizon that is not positive. Since 0.1.
 */
perion_status perion_points_set_horizons(struct perion_points *points,
                                         int64_t count,
                                         const double *horizons);

/**
 * Names a set of points by their indices (from 0, `count` of them), whose order it keeps. The set
 * "all" exists from the start.
 *
 * ERROR_ARGUMENT: name empty, taken, longer than 255 bytes, with blanks around it or control characters, count below 1, an index out of range
 * or given twice. Since 0.1.
 */
perion_status perion_points_add_set(struct perion_points *points,
                                    const char *name,
                                    int64_t count,
                                    const int64_t *indices);

/**
 * Names the set of the points within a box, its faces included, in the order of the points. lower and
 * upper: one length an axis; infinite ones leave a side open.
 *
 * ERROR_ARGUMENT: as perion_points_add_set; a box upside down or without points. Since 0.1.
 */
perion_status perion_points_add_set_box(struct perion_points *points,
                                        const char *name,
                                        const double *lower,
                                        const double *upper);

/**
 * Number of points. Since 0.1.
 */
perion_status perion_points_count(const struct perion_points *points, int64_t *count);

/**
 * Number of axes, 2 or 3. Since 0.1.
 */
perion_status perion_points_dimension(const struct perion_points *points, int32_t *dimension);

/**
 * Number of points of a set. ERROR_ARGUMENT: no such set. Since 0.1.
 */
perion_status perion_points_set_size(const struct perion_points *points,
                                     const char *name,
                                     int64_t *count);

/**
 * Number of named sets; "all", which always exists, is not among them. Since 0.1.
 */
perion_status perion_points_set_count(const struct perion_points *points, int64_t *count);

/**
 * Copies the name of a set to the host, its NUL included; index: from 0, in alphabetical order. capacity: bytes
 * of `name`, of which PERION_NAME_CAPACITY are always enough.
 *
 * ERROR_ARGUMENT: index out of range, capacity too small. Since 0.1.
 */
perion_status perion_points_get_set_name(const struct perion_points *points,
                                         int64_t index,
                                         char *name,
                                         int64_t capacity);

/**
 * The indices of a set, from 0, in the set's order. count: the set's size.
 *
 * ERROR_ARGUMENT: no such set, or another count than its size. Since 0.1.
 */
perion_status perion_points_get_set(const struct perion_points *points,
                                    const char *name,
                                    int64_t count,
                                    int64_t *indices);

/**
 * The positions of all points (lengths), point after point. length: count x dimension.
 *
 * ERROR_ARGUMENT: another length. Since 0.1.
 */
perion_status perion_points_get_coordinates(const struct perion_points *points,
                                            double *coordinates,
                                            int64_t length);

/**
 * The volumes of all points; in 2D areas. length: the number of points.
 *
 * ERROR_ARGUMENT: another length. Since 0.1.
 */
perion_status perion_points_get_volumes(const struct perion_points *points,
                                        double *volumes,
                                        int64_t length);

/**
 * Frees the points and sets the pointer to NULL; NULL, or the address of NULL, is fine. Simulations
 * made of them keep their own copy. ERROR_STATE: another call is using them. Since 0.1.
 */
perion_status perion_points_destroy(struct perion_points **points);

/**
 * Makes a model of a formulation ("bond_based"), with nothing set.
 *
 * ERROR_ARGUMENT: unknown formulation; perion_last_error() names a similar one. Since 0.1.
 */
perion_status perion_model_create(const char *formulation, struct perion_model **model);

/**
 * Sets a number; perion_key_name lists the keys. Values are checked one by one here, and together
 * when a simulation is made.
 *
 * ERROR_ARGUMENT: unknown key (perion_last_error() names a similar one), a key that takes a choice,
 * a value out of its range. ERROR_UNSUPPORTED: a key the formulation does not take. Since 0.1.
 */
perion_status perion_model_set(struct perion_model *model, const char *key, double value);

/**
 * The number last set for a key, or its default.
 *
 * ERROR_ARGUMENT: unknown key, or one that takes a choice. ERROR_STATE: not set, and without a
 * default. Since 0.1.
 */
perion_status perion_model_get(const struct perion_model *model, const char *key, double *value);

/**
 * Makes a choice; perion_key_choices lists them.
 *
 * ERROR_ARGUMENT: unknown key or choice, or a key that takes a number. ERROR_UNSUPPORTED: a key the
 * formulation does not take. Since 0.1.
 */
perion_status perion_model_choose(struct perion_model *model, const char *key, const char *choice);

/**
 * Takes a law of the host's own in place of `material`, with state_size numbers of state at each place where the
 * formulation asks its law: points, or bonds from both ends. Elastic constants are still needed. Simulations keep
 * function and user as long as they live. In 2D the function answers for what lies across, and stress_33 and
 * von_mises_stress are ERROR_UNSUPPORTED. Where a family does not span the body F has what is missing turned along,
 * without stretch, and P counts in the directions spanned.
 *
 * ERROR_ARGUMENT: state_size below 0 or above 100000. ERROR_NULL: no function. ERROR_UNSUPPORTED: a formulation that
 * asks no law. Since 0.1.
 */
perion_status perion_model_set_material_function(struct perion_model *model,
                                                 int64_t state_size,
                                                 perion_material_function function,
                                                 void *user);

/**
 * Frees a model and sets the pointer to NULL; NULL, or the address of NULL, is fine. Simulations made
 * of it keep their own copy. ERROR_STATE: another call is using it. Since 0.1.
 */
perion_status perion_model_destroy(struct perion_model **model);

/**
 * Number of formulations. Since 0.1.
 */
int64_t perion_formulation_count(void);

/**
 * Name of a formulation, index from 0; NULL when there is none. It lives as long as the library.
 * Since 0.1.
 */
const char *perion_formulation_name(int64_t index);

/**
 * What a formulation is, in a line; NULL when there is none. Since 0.1.
 */
const char *perion_formulation_description(int64_t index);

/**
 * Number of keys that models know. Since 0.1.
 */
int64_t perion_key_count(void);

/**
 * Name of a key, index from 0; NULL when there is none. It lives as long as the library. Since 0.1.
 */
const char *perion_key_name(int64_t index);

/**
 * Meaning of a key, its unit kind and the reason for its default; NULL when there is none. Since 0.1.
 */
const char *perion_key_description(int64_t index);

/**
 * Default of a key as text, "" where it has none; NULL when there is no such key. Since 0.1.
 */
const char *perion_key_default(int64_t index);

/**
 * Choices of a key with a bar between them ("strain|stress"), "" for a key that takes a number; NULL
 * when there is no such key. Since 0.1.
 */
const char *perion_key_choices(int64_t index);

/**
 * Brings points and a model together; both are copied and can be destroyed or used again.
 *
 * What follows is set-up, until the first call that needs the bonds: evaluate, commit, step,
 * stable_time_step, energy, health, bond_count, get_bonds, borrow and borrow_const, write_vtk and write_series
 * with such fields, or a get or sum of anything but positions, displacement, velocity and body force. Only then
 * a horizon that reaches no neighbour is found.
 *
 * ERROR_ARGUMENT: the model lacks density, horizon or an elastic constant, or holds what does not fit
 * together or to the dimension. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_create(const struct perion_points *points,
                                       const struct perion_model *model,
                                       struct perion_simulation **simulation);

/**
 * Gives the points of a set another material. All models of a simulation share the formulation and,
 * in 2D, the plane state. Belongs to set-up (see perion_simulation_create).
 *
 * ERROR_ARGUMENT: unknown set, or a model that could not stand alone. ERROR_UNSUPPORTED: another
 * formulation or plane state. ERROR_STATE: set-up has ended. Since 0.1.
 */
perion_status perion_simulation_assign_model(struct perion_simulation *simulation,
                                             const char *set,
                                             const struct perion_model *model);

/**
 * Gives the bonds between two sets a critical energy release rate of their own (energy per area).
 * Belongs to set-up (see perion_simulation_create).
 *
 * ERROR_ARGUMENT: unknown set, a rate that is not positive. ERROR_STATE: set-up has ended. Since 0.1.
 */
perion_status perion_simulation_set_interface(struct perion_simulation *simulation,
                                              const char *set_a,
                                              const char *set_b,
                                              double critical_energy_release_rate);

/**
 * Lets no bond break by its stretch that has an end in the set; the host can still break it.
 *
 * ERROR_ARGUMENT: unknown set. Since 0.1.
 */
perion_status perion_simulation_forbid_failure(struct perion_simulation *simulation,
                                               const char *set);

/**
 * Sets the number of threads, 1 to 4096. Results do not depend on it, to the last bit. The default is
 * PERION_NUM_THREADS, else OMP_NUM_THREADS, else all cores.
 *
 * ERROR_ARGUMENT: out of range. ERROR_STATE: the threads could not be started. Since 0.1.
 */
perion_status perion_simulation_set_threads(struct perion_simulation *simulation,
                                            int32_t threads);

/**
 * Number of points. Since 0.1.
 */
perion_status perion_simulation_point_count(const struct perion_simulation *simulation,
                                            int64_t *count);

/**
 * Number of axes, 2 or 3. Since 0.1.
 */
perion_status perion_simulation_dimension(const struct perion_simulation *simulation,
                                          int32_t *dimension);

/**
 * Frees a simulation, ends its threads and sets the pointer to NULL; NULL, or the address of NULL, is
 * fine. Views that are still borrowed end with it. ERROR_STATE: another call is using it, such as the one whose callback this is. Since 0.1.
 */
perion_status perion_simulation_destroy(struct perion_simulation **simulation);

/**
 * Breaks the bonds of `count` pairs of points for good; pairs: [count][2] indices from 0. Pairs
 * without a bond are passed over, and told to the log. Allowed at any time; what the bonds held is
 * dissipated.
 *
 * ERROR_ARGUMENT: an index out of range, a point paired with itself. Since 0.1.
 */
perion_status perion_simulation_break_bonds(struct perion_simulation *simulation,
                                            int64_t count,
                                            const int64_t *pairs);

/**
 * Breaks every bond that crosses a planar polygon (3D, at least 3 vertices) or a segment (2D, 2
 * vertices) for good. vertices: [vertex_count][dimension] lengths in the reference configuration.
 * Points within 1e-9 spacings of the plane (or what the rounding of large coordinates amounts to) belong
 * to its positive side: where the vertices are seen to run counter-clockwise, in 2D to the left of the
 * segment. The rim belongs to the crack; bonds within the plane stay. A crack that no bond crosses is
 * told to the log.
 *
 * ERROR_ARGUMENT: too few or too many vertices, ones not finite or not in a plane, no extent. Since 0.1.
 */
perion_status perion_simulation_break_crossing(struct perion_simulation *simulation,
                                               int64_t vertex_count,
                                               const double *vertices);

/**
 * Sets the integrity of the bonds of `count` pairs of points: 1 intact, 0 broken. pairs: [count][2]
 * indices from 0; values: [count]. A broken bond stays broken; pairs without a bond are passed over, and
 * told to the log. Allowed at any time: what bonds lose is dissipated, what they gain given by the host.
 *
 * ERROR_ARGUMENT: an index out of range, a point paired with itself, a value outside 0 to 1. Since 0.1.
 */
perion_status perion_simulation_set_bond_integrity(struct perion_simulation *simulation,
                                                   int64_t count,
                                                   const int64_t *pairs,
                                                   const double *values);

/**
 * Lists all bonds, broken ones too, each once: pairs [count][2] indices from 0, stretch [count] at the
 * current displacement, integrity [count] (1 intact, 0 broken). An array that is NULL is left out;
 * capacity: how many bonds the arrays have room for; call with 0 first, to learn the count alone.
 *
 * ERROR_ARGUMENT: capacity below the count and not 0. Since 0.1.
 */
perion_status perion_simulation_get_bonds(const struct perion_simulation *simulation,
                                          int64_t capacity,
                                          int64_t *pairs_or_null,
                                          double *stretch_or_null,
                                          double *integrity_or_null,
                                          int64_t *count);

/**
 * Number of bonds, broken or not, each counted once. Since 0.1.
 */
perion_status perion_simulation_bond_count(const struct perion_simulation *simulation,
                                           int64_t *count);

/**
 * Prescribes a constant on a set along an axis (from 0), from the next step on. Per point and axis the
 * last displacement or velocity wins and replaces the other for good; body forces and tractions of different
 * sets add, the same set and axis replaces. A traction acts on the layers below its set, see
 * perion_simulation_set_surface_areas. A displacement is where the point is put at once at the end of
 * the next step: ramp it by a table for smooth loading.
 *
 * ERROR_ARGUMENT: unknown set or quantity, axis out of range, value not finite. Since 0.1.
 */
perion_status perion_simulation_prescribe(struct perion_simulation *simulation,
                                          const char *set,
                                          perion_quantity quantity,
                                          int32_t axis,
                                          double value);

/**
 * Prescribes a table over time: linear between its times, constant outside. times: [count],
 * increasing; values: [count]. Both are copied.
 *
 * ERROR_ARGUMENT: as perion_simulation_prescribe; count below 1, times that do not increase. Since 0.1.
 */
perion_status perion_simulation_prescribe_table(struct perion_simulation *simulation,
                                                const char *set,
                                                perion_quantity quantity,
                                                int32_t axis,
                                                int64_t count,
                                                const double *times,
                                                const double *values);

/**
 * Prescribes a function of time and place, asked once per time that a step needs: displacements at the
 * step's end, velocities at its middle and end, body forces at its end (and at the first step's
 * beginning). `user` is handed back to it.
 *
 * ERROR_NULL: no function. ERROR_ARGUMENT: as perion_simulation_prescribe. A value that is not finite
 * ends a later step with ERROR_NUMERIC. Since 0.1.
 */
perion_status perion_simulation_prescribe_function(struct perion_simulation *simulation,
                                                   const char *set,
                                                   perion_quantity quantity,
                                                   int32_t axis,
                                                   perion_function function,
                                                   void *user);

/**
 * Prescribes one value a point of the set, in the set's order; copied and held until replaced.
 *
 * ERROR_ARGUMENT: as perion_simulation_prescribe; count is not the set's size. Since 0.1.
 */
perion_status perion_simulation_prescribe_values(struct perion_simulation *simulation,
                                                 const char *set,
                                                 perion_quantity quantity,
                                                 int32_t axis,
                                                 int64_t count,
                                                 const double *values);

/**
 * Ends what was prescribed on a set along an axis; the points are free there from the next step on.
 *
 * ERROR_ARGUMENT: nothing is prescribed there, or other sets have taken all its points. Since 0.1.
 */
perion_status perion_simulation_release(struct perion_simulation *simulation,
                                        const char *set,
                                        perion_quantity quantity,
                                        int32_t axis);

/**
 * Gives the areas of the surface along a set, one a point of the set, in its order: a traction then makes a force of a
 * point's area times its value, spread over the layers below the point that a stress up to the surface would pull on.
 * Without areas they are estimated, well on lattices; give them for clouds without order and for bodies thinner than
 * four horizons. areas: [count], copied.
 *
 * ERROR_ARGUMENT: unknown set, count is not the set's size, an area not positive and finite. Since 0.1.
 */
perion_status perion_simulation_set_surface_areas(struct perion_simulation *simulation,
                                                  const char *set,
                                                  int64_t count,
                                                  const double *areas);

/**
 * Copies a field of all points to the host, point after point in the host's order. length: number of
 * points, times the dimension for vectors and its square for tensors, which lie row after row as an array
 * [count][dimension][dimension] does. Derived fields are computed when asked for.
 *
 * ERROR_ARGUMENT: unknown field, another length. ERROR_STATE: ACCELERATION, REACTION or BODY_FORCE of
 * conditions after a change of state or conditions; evaluate first. ERROR_NUMERIC: a force, deformation or
 * stress that is not finite. ERROR_UNSUPPORTED: STRESS_33 in 3D. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_get(const struct perion_simulation *simulation,
                                    perion_field field,
                                    double *values,
                                    int64_t length);

/**
 * Sets DISPLACEMENT, POSITION, VELOCITY or the host's BODY_FORCE of all points, point after point in the
 * host's order. length: number of points times the dimension. Nothing is set unless all values are
 * finite.
 *
 * ERROR_ARGUMENT: unknown field, another length, a value that is not finite. ERROR_UNSUPPORTED: a field
 * that cannot be set. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_set(struct perion_simulation *simulation,
                                    perion_field field,
                                    const double *values,
                                    int64_t length);

/**
 * As perion_simulation_get for the points of a set in its order (NULL: all points), with `stride`
 * doubles from one point to the next; what lies between is not touched. count: number of these points.
 *
 * ERROR_ARGUMENT: also unknown set, another count, stride below the numbers of a point. Since 0.1.
 */
perion_status perion_simulation_get_strided(const struct perion_simulation *simulation,
                                            const char *set_or_null,
                                            perion_field field,
                                            double *values,
                                            int64_t count,
                                            int64_t stride);

/**
 * As perion_simulation_set for the points of a set in its order (NULL: all points), with `stride`
 * doubles from one point to the next. count: number of these points.
 *
 * ERROR_ARGUMENT: also unknown set, another count, stride below the dimension. Since 0.1.
 */
perion_status perion_simulation_set_strided(struct perion_simulation *simulation,
                                            const char *set_or_null,
                                            perion_field field,
                                            const double *values,
                                            int64_t count,
                                            int64_t stride);

/**
 * Sums a field over a set (NULL: all points), into `dimension` numbers for vectors, their square
 * for tensors, else one. A force-displacement curve is the sum of REACTION over the held end, step by step.
 *
 * ERROR_ARGUMENT: unknown field or set; otherwise as perion_simulation_get. Since 0.1.
 */
perion_status perion_simulation_sum(const struct perion_simulation *simulation,
                                    perion_field field,
                                    const char *set_or_null,
                                    double *components);

/**
 * The gradient of a field of the host's, field[count][components], over the families of the simulation at
 * its current displacement: result[count][components][dimension] = sum w (g_j - g_i) h^T V, w the influence
 * function, broken bonds left out. count is the number of points, in the host's order; field and result may
 * be anything, one in the other too. A point without bonds has 0; where the bonds of a point do not span the
 * body, the derivative is that along what they span. Ends set-up.
 *
 * ERROR_ARGUMENT: unknown operator, components below 1, a number that is not finite. ERROR_NUMERIC: a
 * derivative that is not finite. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_gradient(const struct perion_simulation *simulation,
                                         perion_operator operator_,
                                         int32_t components,
                                         const double *field,
                                         double *result);

/**
 * The divergence of a field of the host's of vectors or tensors, field[count][components / dimension][dimension],
 * as perion_simulation_gradient: result[count][components / dimension] = sum w (T_j - T_i) h V.
 *
 * ERROR_ARGUMENT: also components no multiple of the dimension. Otherwise as perion_simulation_gradient. Since 0.1.
 */
perion_status perion_simulation_divergence(const struct perion_simulation *simulation,
                                           perion_operator operator_,
                                           int32_t components,
                                           const double *field,
                                           double *result);

/**
 * Clears the struct and sets its struct_size; struct_size: sizeof(perion_view) as the host was
 * compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_view_init(struct perion_view *view, int64_t struct_size);

/**
 * Lends the host DISPLACEMENT, VELOCITY or its own BODY_FORCE to read and write. Until all views are
 * returned, calls that change the simulation give ERROR_STATE.
 *
 * ERROR_ARGUMENT: struct_size not set or too small for a view, unknown field. ERROR_UNSUPPORTED: a field
 * that cannot be lent. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_borrow(struct perion_simulation *simulation,
                                       perion_field field,
                                       struct perion_view *view);

/**
 * Lends the host DISPLACEMENT, VELOCITY, ACCELERATION or INTERNAL_FORCE to read only: `data` must not be
 * written to. A run of steps
 * ends with ERROR_STATE when its progress callback has borrowed a view and not returned it.
 *
 * ERROR_ARGUMENT: as perion_simulation_borrow. ERROR_STATE: ACCELERATION or INTERNAL_FORCE after a change;
 * evaluate first. ERROR_UNSUPPORTED: a field that is computed when asked for; get it. Since 0.1.
 */
perion_status perion_simulation_borrow_const(const struct perion_simulation *simulation,
                                             perion_field field,
                                             struct perion_view *view);

/**
 * Returns a borrowed view and clears it. One that was lent to read only can be returned in a progress
 * callback too.
 *
 * ERROR_ARGUMENT: not a view that this simulation has lent and not yet got back. ERROR_NUMERIC: the host
 * has written a value that is not finite (the message names the point); the view stays borrowed, mend
 * it and return it again. Since 0.1.
 */
perion_status perion_simulation_return(struct perion_simulation *simulation,
                                       struct perion_view *view);

/**
 * Computes the internal force at the current displacement with bonds as they are, and from it and the
 * loads at the current time acceleration and reactions. Breaks nothing, advances nothing.
 *
 * ERROR_ARGUMENT: the horizon reaches no neighbour. ERROR_NUMERIC: a force that is not finite; the
 * message names the point. ERROR_INTERRUPTED: a function stopped. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_evaluate(struct perion_simulation *simulation);

/**
 * Accepts the current displacement as a completed step of a host that steps itself: breaks the bonds
 * stretched beyond their limit, adds up what they held, and moves the clock on by time_step (0 is
 * allowed). For velocity Verlet: set the displacement, commit, evaluate.
 *
 * ERROR_ARGUMENT: time_step negative or not finite. ERROR_NUMERIC. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_commit(struct perion_simulation *simulation,
                                       double time_step);

/**
 * A time step at which step() is stable near the current displacement, with bonds as they are: 2 over the largest
 * frequency of the forces as they are linear there, less a margin: 2 to 5 percent below the limit. Materials that flow
 * count with their elastic stiffness. DBL_MAX where no bond acts. Leaves the state as it is; ends set-up.
 *
 * It costs up to sixty forces, and ten when nothing has changed since it was last asked for than that a few bonds have
 * broken. Strains, turns and damage change it: ask again as they grow, or take a part of it (0.8; half of it where
 * bonds stretch by a tenth and more), or let perion_simulation_advance see to it. It promises nothing for bonds
 * pressed to a fraction of their length: see smallest_stretch of perion_health. Where forces have no potential (strong
 * forms, deformed bonds, literal forces, laws with memory and those of the host) it follows from the eigenvalue of the
 * largest size and is no guarantee: see stable_step_is_guaranteed of perion_health.
 *
 * ERROR_ARGUMENT: the horizon reaches no neighbour. ERROR_NUMERIC: forces at the current displacement are
 * not finite, or no step is stable. ERROR_INTERRUPTED: a function stopped. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_stable_time_step(struct perion_simulation *simulation,
                                                 double *time_step);

/**
 * Makes `steps` velocity Verlet steps: predict, break bonds, force, correct. A failure leaves the
 * simulation as the last completed step left it; perion_simulation_step_count says which. Above the
 * stable step it warns through the log and in health. The first call looks whether it is, and calls with a larger
 * step or after bonds have changed: where forces are the slope of an energy that takes some 5 forces at a hundredth
 * of the stable step, 20 at half of it, up to 60 near it.
 *
 * ERROR_ARGUMENT: time_step not positive and finite or more than 10 times the stable one, steps below
 * 0. ERROR_NUMERIC: a motion that is not finite; the message names the point. ERROR_INTERRUPTED: a
 * callback stopped. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_step(struct perion_simulation *simulation,
                                     double time_step,
                                     int64_t steps);

/**
 * Sets the callback that step, advance, solve and relax tell of their progress, NULL for none; `user` is handed back to
 * it. Since 0.1.
 */
perion_status perion_simulation_set_progress(struct perion_simulation *simulation,
                                             perion_progress callback,
                                             void *user);

/**
 * Sets the callback that takes messages, NULL for none (the default: silence); `user` is handed back
 * to it. Since 0.1.
 */
perion_status perion_simulation_set_log(struct perion_simulation *simulation,
                                        perion_log callback,
                                        void *user);

/**
 * Time of the last completed step. Since 0.1.
 */
perion_status perion_simulation_time(const struct perion_simulation *simulation, double *time);

/**
 * Sets the clock, along which tables and functions are asked. ERROR_ARGUMENT: not finite. Since 0.1.
 */
perion_status perion_simulation_set_time(struct perion_simulation *simulation,
                                         double time);

/**
 * Number of completed steps, commits included. Since 0.1.
 */
perion_status perion_simulation_step_count(const struct perion_simulation *simulation,
                                           int64_t *count);

/**
 * Clears the struct and sets its struct_size; struct_size: sizeof(perion_report) as the host was
 * compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_report_init(struct perion_report *report, int64_t struct_size);

/**
 * Clears the struct, which stands for all defaults, and sets its struct_size; struct_size:
 * sizeof(perion_advance_options) as the host was compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_advance_options_init(struct perion_advance_options *advance_options,
                                 int64_t struct_size);

/**
 * Makes velocity Verlet steps up to the time `until`, and lands on it exactly. Steps are a share of the stable step,
 * which is found anew on the way; NULL options are the defaults. The report, unless NULL, tells what was done, also
 * of a run that failed on its way. The progress callback is told of each step, with the total as it looks then.
 *
 * ERROR_ARGUMENT: until not finite or before the current time, safety outside 0 to 1, largest_time_step or interval
 * below 0, struct_size not set. ERROR_NUMERIC: a motion that is not finite, no step that is stable.
 * ERROR_INTERRUPTED: a callback stopped. ERROR_MEMORY. A failure leaves the simulation as the last completed step left
 * it. Since 0.1.
 */
perion_status perion_simulation_advance(struct perion_simulation *simulation,
                                        double until,
                                        const struct perion_advance_options *advance_options_or_null,
                                        struct perion_report *report_or_null);

/**
 * Clears the struct, which stands for all defaults, and sets its struct_size; struct_size:
 * sizeof(perion_solve_options) as the host was compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_solve_options_init(struct perion_solve_options *solve_options,
                               int64_t struct_size);

/**
 * Clears the struct, which stands for all defaults, and sets its struct_size; struct_size:
 * sizeof(perion_relax_options) as the host was compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_relax_options_init(struct perion_relax_options *relax_options,
                               int64_t struct_size);

/**
 * Finds the equilibrium under the conditions by Newton's method on the forces, going on from the last completed step.
 * Constants go linearly from what they were at the last equilibrium to what they are, tables and functions are asked
 * along the time to time_end. Bonds that an equilibrium would break are broken for good, and it is looked for again.
 * Each load step counts as a completed step, at which the body is at rest and materials remember. NULL options are the
 * defaults. The report, unless NULL, tells what was done, also of a run that failed on its way; it may bring room for
 * the residuals. The progress callback is told of each load step, with the total as it looks then.
 *
 * ERROR_ARGUMENT: an option out of range, struct_size not set. ERROR_STATE: a velocity is prescribed.
 * ERROR_CONVERGENCE: load steps were cut to the smallest without success; the text has reason and residuals.
 * ERROR_INTERRUPTED: a callback stopped. ERROR_MEMORY. A failure leaves the simulation as the last completed load step
 * left it. Since 0.1.
 */
perion_status perion_simulation_solve(struct perion_simulation *simulation,
                                      const struct perion_solve_options *solve_options_or_null,
                                      struct perion_report *report_or_null);

/**
 * Finds the equilibrium under the conditions at the current time by adaptive dynamic relaxation: a damped motion with
 * masses of its own, of one force a step, for bodies whose linear systems are hard to solve. Loads act at once,
 * displacements over the first steps. Bonds that the equilibrium would break are broken for good, and the body relaxes
 * again. The result counts as one completed step, at which the body is at rest; the time stands still. NULL options are
 * the defaults. The report, unless NULL, tells what was done, also of a run that failed; it may bring room for the
 * residuals and the energies of the motion. The progress callback is told after each force of the motion how many steps it has made
 * and, as the total, may come to, as it looks then; it sees the body as it was, in the last call at rest. The log is told of
 * the residual every hundred steps.
 *
 * ERROR_ARGUMENT: an option out of range, struct_size not set. ERROR_STATE: a velocity is prescribed.
 * ERROR_CONVERGENCE: the steps did not lead there; the text has reason and residuals. ERROR_INTERRUPTED: a callback
 * stopped. ERROR_MEMORY. A failure leaves the simulation as the last completed step left it. Since 0.1.
 */
perion_status perion_simulation_relax(struct perion_simulation *simulation,
                                      const struct perion_relax_options *relax_options_or_null,
                                      struct perion_report *report_or_null);

/**
 * Clears the struct and sets its struct_size; struct_size: sizeof(perion_energy) as the host was
 * compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_energy_init(struct perion_energy *energy, int64_t struct_size);

/**
 * Clears the struct and sets its struct_size; struct_size: sizeof(perion_health) as the host was
 * compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_health_init(struct perion_health *health, int64_t struct_size);

/**
 * Clears the struct and sets its struct_size; struct_size: sizeof(perion_memory) as the host was
 * compiled, so that it works with later libraries too. Since 0.1.
 */
void perion_memory_init(struct perion_memory *memory, int64_t struct_size);

/**
 * The energy balance; costs a sweep over the bonds. Ends set-up.
 *
 * ERROR_ARGUMENT: struct_size not set. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_energy(const struct perion_simulation *simulation,
                                       struct perion_energy *energy);

/**
 * What to look at before trusting a result: isolated, detached and degenerate points, broken bonds, time
 * step, compressed bonds. Costs a sweep over the bonds; ends set-up.
 *
 * ERROR_ARGUMENT: struct_size not set, the horizon reaches no neighbour. ERROR_MEMORY. Since 0.1.
 */
perion_status perion_simulation_health(const struct perion_simulation *simulation,
                                       struct perion_health *health);

/**
 * Heap bytes held. ERROR_ARGUMENT: struct_size not set. Since 0.1.
 */
perion_status perion_simulation_memory(const struct perion_simulation *simulation,
                                       struct perion_memory *memory);

/**
 * Writes the current positions and `field_count` fields as a .vtu file for ParaView; an older file is
 * replaced as a whole, or kept when this fails. Vectors have 3 numbers and tensors 9, row after row; what a
 * 2D body does not have of them is 0.
 *
 * ERROR_IO: it cannot be written. ERROR_ARGUMENT: unknown field, or one named twice; otherwise as
 * perion_simulation_get. Since 0.1.
 */
perion_status perion_simulation_write_vtk(const struct perion_simulation *simulation,
                                          const char *path,
                                          int64_t field_count,
                                          const perion_field *fields);

/**
 * Writes the next .vtu of a series, NAME_000000.vtu and so on, beside NAME.pvd, which lists them with
 * their times and is what to open in ParaView. The series starts anew with each simulation.
 *
 * ERROR_ARGUMENT: pvd_path does not end in .pvd; otherwise as perion_simulation_write_vtk. Since 0.1.
 */
perion_status perion_simulation_write_series(const struct perion_simulation *simulation,
                                             const char *pvd_path,
                                             int64_t field_count,
                                             const perion_field *fields);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* PERION_H */
