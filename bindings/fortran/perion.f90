!> Perion from Fortran: `use perion` is all that a program needs.
!>
!> Objects are `perion_points`, `perion_model` and `perion_simulation`. `create` makes one,
!> `destroy` frees it, and what goes out of scope is freed too. A simulation keeps copies of its
!> points and models. Making an object anew frees the old one once the new one is there. Make objects
!> in subroutines: what a function gives back is never freed by gfortran 12.
!>
!> Objects do not copy: `a = b` stops with an error, unless neither has been created. Two ways round
!> that are open and must not be used: `allocate (a, source=b)` and, with gfortran 12, assignment of
!> a type of the host's that has objects as an allocatable component. `move_alloc` is fine.
!> In OpenMP, objects of a thread's own are declared in a `block` or are one of an array each, never
!> `private` or `firstprivate`, which copy handles.
!>
!> Errors: a call that can fail takes `error` last. Left out, a failure is an `error stop` with its
!> text. Given, it is allocated when the call has failed, and holds the number error%status and the
!> text error%message. A refused call changes nothing, its outputs neither. Any call may give
!> PERION_ERROR_NULL (not created), ERROR_STATE, ERROR_MEMORY and ERROR_POISONED, and ERROR_ARGUMENT
!> for an array of another shape.
!>
!> Numbers are real(c_double), which is double precision; integers are of 32 or 64 bits, but fields
!> and quantities, always integer(c_int32_t). Points, axes and pairs count from 1; texts of the
!> library, which count from 0 as in C, say so. Vectors are arrays (dimension,count), one number a
!> point is (count). Sections such as state(1:3,:) of a host's (6,n) array are used in place where
!> the numbers of a point are neighbours; other sections are copied. Blanks at the end of text do
!> not count.
!>
!> Units are the host's own, consistent ones. One object must not be used by two threads at once,
!> but for calls that leave it unchanged. A host's callbacks run on the calling thread; they must
!> return, so give `error` to calls within them.
module perion
  use, intrinsic :: iso_c_binding, only: c_double, c_int32_t, c_int64_t, c_null_ptr, c_ptr
  use perion_c, only: perion_abi_version, perion_version, &
      PERION_VERSION_MAJOR, PERION_VERSION_MINOR, PERION_VERSION_PATCH, PERION_ABI_VERSION_CONSTANT, &
      PERION_NAME_CAPACITY, &
      PERION_OK, PERION_ERROR_NULL, PERION_ERROR_ARGUMENT, PERION_ERROR_STATE, PERION_ERROR_MEMORY, &
      PERION_ERROR_IO, PERION_ERROR_FORMAT, PERION_ERROR_NUMERIC, PERION_ERROR_CONVERGENCE, &
      PERION_ERROR_INTERRUPTED, PERION_ERROR_UNSUPPORTED, PERION_ERROR_POISONED, &
      PERION_ERROR_INTERNAL, &
      PERION_QUANTITY_DISPLACEMENT, PERION_QUANTITY_VELOCITY, PERION_QUANTITY_BODY_FORCE, &
      PERION_QUANTITY_TRACTION, &
      PERION_KRYLOV_AUTOMATIC, PERION_KRYLOV_CONJUGATE_GRADIENTS, &
      PERION_KRYLOV_MINIMAL_RESIDUALS, PERION_KRYLOV_GENERALISED_MINIMAL_RESIDUALS, &
      PERION_PRECONDITIONER_GLOBAL, PERION_PRECONDITIONER_BLOCK_DIAGONAL, &
      PERION_PRECONDITIONER_NONE, &
      PERION_FIELD_REFERENCE_POSITION, PERION_FIELD_POSITION, PERION_FIELD_DISPLACEMENT, &
      PERION_FIELD_VELOCITY, PERION_FIELD_ACCELERATION, PERION_FIELD_INTERNAL_FORCE, &
      PERION_FIELD_BODY_FORCE, PERION_FIELD_REACTION, PERION_FIELD_VOLUME, PERION_FIELD_DENSITY, &
      PERION_FIELD_DAMAGE, PERION_FIELD_STRAIN_ENERGY_DENSITY, &
      PERION_FIELD_STABILIZATION_ENERGY_DENSITY, &
      PERION_FIELD_DISSIPATED_ENERGY_DENSITY, PERION_FIELD_DEFORMATION_GRADIENT, &
      PERION_FIELD_STRAIN, PERION_FIELD_PLASTIC_STRAIN, PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN, &
      PERION_FIELD_FIRST_PIOLA_STRESS, PERION_FIELD_CAUCHY_STRESS, &
      PERION_FIELD_STRESS_33, PERION_FIELD_VON_MISES_STRESS, PERION_FIELD_DILATATION, &
      PERION_FIELD_NEIGHBOR_COUNT, &
      PERION_FIELD_TIME_STEP_ESTIMATE, PERION_FIELD_SHAPE_TENSOR, &
      PERION_FIELD_MIXED_SHAPE_TENSOR, PERION_FIELD_DEFORMED_SHAPE_TENSOR, &
      PERION_OPERATOR_REFERENCE_UNDEFORMED, PERION_OPERATOR_REFERENCE_DEFORMED, &
      PERION_OPERATOR_CURRENT_UNDEFORMED, PERION_OPERATOR_CURRENT_DEFORMED, &
      PERION_LOG_LEVEL_WARNING, PERION_LOG_LEVEL_INFORMATION, raw_view => perion_view
  use perion_support, only: perion_error
  implicit none
  private

  public :: perion_points, perion_model, perion_simulation, perion_error
  public :: perion_energy, perion_health, perion_memory, perion_view
  public :: perion_advance_options, perion_solve_options, perion_relax_options, perion_report
  public :: perion_function, perion_material, perion_progress, perion_log
  public :: perion_version, perion_abi_version, perion_version_string, perion_build_info
  public :: perion_has_feature, perion_status_string, perion_last_error
  public :: perion_formulation_count, perion_formulation_name, perion_formulation_description
  public :: perion_key_count, perion_key_name, perion_key_description, perion_key_default
  public :: perion_key_choices
  public :: PERION_VERSION_MAJOR, PERION_VERSION_MINOR, PERION_VERSION_PATCH
  public :: PERION_ABI_VERSION_CONSTANT, PERION_NAME_CAPACITY
  public :: PERION_OK, PERION_ERROR_NULL, PERION_ERROR_ARGUMENT, PERION_ERROR_STATE
  public :: PERION_ERROR_MEMORY, PERION_ERROR_IO, PERION_ERROR_FORMAT, PERION_ERROR_NUMERIC
  public :: PERION_ERROR_CONVERGENCE, PERION_ERROR_INTERRUPTED, PERION_ERROR_UNSUPPORTED
  public :: PERION_ERROR_POISONED, PERION_ERROR_INTERNAL
  public :: PERION_QUANTITY_DISPLACEMENT, PERION_QUANTITY_VELOCITY, PERION_QUANTITY_BODY_FORCE
  public :: PERION_QUANTITY_TRACTION
  public :: PERION_KRYLOV_AUTOMATIC, PERION_KRYLOV_CONJUGATE_GRADIENTS
  public :: PERION_KRYLOV_MINIMAL_RESIDUALS, PERION_KRYLOV_GENERALISED_MINIMAL_RESIDUALS
  public :: PERION_PRECONDITIONER_GLOBAL, PERION_PRECONDITIONER_BLOCK_DIAGONAL
  public :: PERION_PRECONDITIONER_NONE
  public :: PERION_OPERATOR_REFERENCE_UNDEFORMED, PERION_OPERATOR_REFERENCE_DEFORMED
  public :: PERION_OPERATOR_CURRENT_UNDEFORMED, PERION_OPERATOR_CURRENT_DEFORMED
  public :: PERION_FIELD_REFERENCE_POSITION, PERION_FIELD_POSITION, PERION_FIELD_DISPLACEMENT
  public :: PERION_FIELD_VELOCITY, PERION_FIELD_ACCELERATION, PERION_FIELD_INTERNAL_FORCE
  public :: PERION_FIELD_BODY_FORCE, PERION_FIELD_REACTION, PERION_FIELD_VOLUME
  public :: PERION_FIELD_DENSITY, PERION_FIELD_DAMAGE, PERION_FIELD_STRAIN_ENERGY_DENSITY
  public :: PERION_FIELD_STABILIZATION_ENERGY_DENSITY
  public :: PERION_FIELD_DISSIPATED_ENERGY_DENSITY, PERION_FIELD_DEFORMATION_GRADIENT
  public :: PERION_FIELD_STRAIN, PERION_FIELD_FIRST_PIOLA_STRESS, PERION_FIELD_CAUCHY_STRESS
  public :: PERION_FIELD_PLASTIC_STRAIN, PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN
  public :: PERION_FIELD_STRESS_33, PERION_FIELD_VON_MISES_STRESS, PERION_FIELD_DILATATION
  public :: PERION_FIELD_NEIGHBOR_COUNT
  public :: PERION_FIELD_TIME_STEP_ESTIMATE, PERION_FIELD_SHAPE_TENSOR
  public :: PERION_FIELD_MIXED_SHAPE_TENSOR, PERION_FIELD_DEFORMED_SHAPE_TENSOR
  public :: PERION_LOG_LEVEL_WARNING, PERION_LOG_LEVEL_INFORMATION

  !> A cloud of points with volumes, optional horizons and named sets.
  type :: perion_points
    private
    type(c_ptr) :: handle = c_null_ptr
  contains
    procedure :: create => points_create
    procedure :: create_block => points_create_block
    procedure :: read => points_read
    procedure :: set_horizons => points_set_horizons
    generic :: add_set => points_add_set_int64, points_add_set_int32
    procedure :: add_set_box => points_add_set_box
    generic :: count => points_count_int64, points_count_int32
    generic :: dimension => points_dimension_int64, points_dimension_int32
    generic :: set_count => points_set_count_int64, points_set_count_int32
    generic :: get_set_name => points_get_set_name_int64, points_get_set_name_int32
    generic :: set_size => points_set_size_int64, points_set_size_int32
    generic :: get_set => points_get_set_int64, points_get_set_int32
    procedure :: get_coordinates => points_get_coordinates
    procedure :: get_volumes => points_get_volumes
    procedure :: destroy => points_destroy
    generic :: assignment(=) => points_assign
    procedure, private :: points_add_set_int64, points_add_set_int32
    procedure, private :: points_count_int64, points_count_int32
    procedure, private :: points_dimension_int64, points_dimension_int32
    procedure, private :: points_set_count_int64, points_set_count_int32
    procedure, private :: points_get_set_name_int64, points_get_set_name_int32
    procedure, private :: points_set_size_int64, points_set_size_int32
    procedure, private :: points_get_set_int64, points_get_set_int32
    procedure, private :: points_assign
    final :: points_finalize
  end type perion_points

  !> A material law of the host's own: a type that extends this one, with what the law needs to know
  !> as components. See model%set_material_function.
  type, abstract :: perion_material
  contains
    procedure(perion_material_answer), deferred :: answer
  end type perion_material

  !> What is handed to C as the user pointer of a material function. Its model and the simulations made
  !> of it share it; the last of them frees it.
  type :: material_holder
    class(perion_material), pointer :: host => null()
    integer(c_int64_t) :: state_size = 0
    !> Of the points that simulations which use it have, while there are any.
    integer(c_int64_t) :: dimension = 0
    integer(c_int64_t) :: simulations = 0
    logical :: has_model = .true.
  end type material_holder

  !> A material function that a simulation uses.
  type :: material_use
    type(material_holder), pointer :: holder => null()
    type(material_use), pointer :: next => null()
  end type material_use

  !> A formulation with its material and options.
  type :: perion_model
    private
    type(c_ptr) :: handle = c_null_ptr
    type(material_holder), pointer :: material => null()
  contains
    procedure :: create => model_create
    procedure :: set => model_set
    procedure :: get => model_get
    procedure :: choose => model_choose
    generic :: set_material_function => set_material_function_int64, set_material_function_int32
    procedure :: destroy => model_destroy
    generic :: assignment(=) => model_assign
    procedure, private :: set_material_function_int64, set_material_function_int32
    procedure, private :: model_assign
    final :: model_finalize
  end type perion_model

  !> A function that the host prescribes: a type of its own that extends this one, with what the
  !> function needs to know as components. See simulation%prescribe_function.
  type, abstract :: perion_function
  contains
    procedure(perion_function_evaluate), deferred :: evaluate
  end type perion_function

  !> Told after each step, load step or step of relax: a type of the host's own that extends this one. See
  !> simulation%set_progress.
  type, abstract :: perion_progress
  contains
    procedure(perion_progress_report), deferred :: report
  end type perion_progress

  !> Takes messages: a type of the host's own that extends this one. See simulation%set_log.
  type, abstract :: perion_log
  contains
    procedure(perion_log_take), deferred :: take
  end type perion_log

  !> The energy of a simulation, in units of energy.
  type :: perion_energy
    !> sum 1/2 rho V v^2
    real(c_double) :: kinetic = 0
    !> sum V W, what the bonds hold
    real(c_double) :: elastic = 0
    !> what broken bonds held, and the work of plastic flow
    real(c_double) :: dissipated = 0
    !> work of body forces, and of what holds prescribed points
    real(c_double) :: external_work = 0
    !> kinetic + elastic + dissipated that neither external work nor the start accounts for.
    !> Velocity Verlet lets it swing by about (omega dt)^2/8 of the energy; growing above that,
    !> energy comes out of nothing. Steps that the host commits itself are not in it: their work is
    !> not known
    real(c_double) :: closure_error = 0
    !> part of dissipated that plastic flow took
    real(c_double) :: plastic = 0
  end type perion_energy

  !> What to look at before trusting a result.
  type :: perion_health
    !> points without a neighbour in the reference configuration
    integer(c_int64_t) :: isolated_points = 0
    !> the first of them, 0 for none
    integer(c_int64_t) :: first_isolated_point = 0
    !> points that had neighbours and have lost all bonds
    integer(c_int64_t) :: detached_points = 0
    !> the first of them, 0 for none
    integer(c_int64_t) :: first_detached_point = 0
    !> bonds in all
    integer(c_int64_t) :: bonds = 0
    !> bonds broken
    integer(c_int64_t) :: broken_bonds = 0
    !> last time step over the stable one as it was last found; 0 before the first step. Near 1 the limit
    !> is near
    real(c_double) :: time_step_ratio = 0
    !> smallest stretch of a bond that is not broken, 0 when none is compressed; below about -0.3
    !> bonds are on their way to collapse, and the stable step promises nothing
    real(c_double) :: smallest_stretch = 0
    !> points with bonds whose families do not span the body (a plate one point thick, a chain, a family
    !> thinned by broken bonds) or do not bear the gradient_order asked for: the material is asked in the
    !> directions spanned alone, without stress across, and the gradient is of first order
    integer(c_int64_t) :: degenerate_points = 0
    !> the first of them, 0 for none
    integer(c_int64_t) :: first_degenerate_point = 0
    !> the stable step as it was last found; 0 before that. Where the host's own steps are known to be below it
    !> no more is looked for: then an estimate, no lower than these
    real(c_double) :: stable_time_step = 0
    !> 1 where it was found from forces that have a potential, and is stable for small motions about the
    !> state it was found at; 0 where it is an estimate
    integer(c_int64_t) :: stable_step_is_guaranteed = 0
  end type perion_health

  !> How advance chooses its steps.
  type :: perion_advance_options
    !> time step over the stable one, above 0 and at most 1; 0 for the default, 0.8
    real(c_double) :: safety = 0
    !> steps are never longer; 0 for no limit
    real(c_double) :: largest_time_step = 0
    !> steps after which the stable one is found anew, at the cost of ten forces; after a quarter of them
    !> when bonds have broken; 0 for the default, 100
    integer(c_int64_t) :: interval = 0
  end type perion_advance_options

  !> How solve looks for equilibrium; a component that is 0 stands for its default.
  type :: perion_solve_options
    !> time at the end, along which tables and functions are asked; 0 for the current time
    real(c_double) :: time_end = 0
    !> forces out of balance over loads or reactions, whichever are larger; 0 for the default, 1e-8
    real(c_double) :: tolerance = 0
    !> load steps, cut where one fails, as long again where they are easy; 0 for the default, 1
    integer(c_int64_t) :: load_steps = 0
    !> share of the way that a load step has at least; 0 for the default, 1e-3
    real(c_double) :: smallest_load_step = 0
    !> linear systems that a load step may take, each time bonds have broken; 0 for the default, 25
    integer(c_int64_t) :: iterations = 0
    !> products of the stiffness that a linear system may take; 0 for the default, 2000
    integer(c_int64_t) :: products = 0
    !> how often bonds may break within a load step; 0 for the default, 200
    integer(c_int64_t) :: breaks = 0
    !> one of the PERION_KRYLOV_ constants
    integer(c_int32_t) :: krylov = PERION_KRYLOV_AUTOMATIC
    !> one of the PERION_PRECONDITIONER_ constants
    integer(c_int32_t) :: preconditioner = PERION_PRECONDITIONER_GLOBAL
  end type perion_solve_options

  !> How relax looks for equilibrium; a component that is 0 stands for its default.
  type :: perion_relax_options
    !> forces out of balance over loads or reactions, whichever are larger; 0 for the default, 1e-6
    real(c_double) :: tolerance = 0
    !> energy of the damped motion over the largest that it had; 0 for the default, 1e-9
    real(c_double) :: energy_tolerance = 0
    !> steps that it may take, each time bonds have broken; 0 for the default, 100000
    integer(c_int64_t) :: steps = 0
    !> steps over which prescribed displacements are applied; 0 for the default, 100
    integer(c_int64_t) :: ramp = 0
    !> how often bonds may break; 0 for the default, 200
    integer(c_int64_t) :: breaks = 0
  end type perion_relax_options

  !> What a run has done: advance, solve or relax. Components that do not belong to it are left as they are.
  type :: perion_report
    !> steps completed; of solve load steps, of relax 1
    integer(c_int64_t) :: steps = 0
    !> how often the stable step was found
    integer(c_int64_t) :: estimates = 0
    !> the smallest time step, 0 when none was made
    real(c_double) :: smallest_time_step = 0
    !> the largest time step
    real(c_double) :: largest_time_step = 0
    !> the stable step as it was last found
    real(c_double) :: stable_time_step = 0
    !> time of the last completed step
    real(c_double) :: time = 0
    !> of solve: load steps that failed and were cut
    integer(c_int64_t) :: cuts = 0
    !> of solve: linear systems solved; of relax: its steps
    integer(c_int64_t) :: iterations = 0
    !> of solve and relax: forces evaluated
    integer(c_int64_t) :: evaluations = 0
    !> of solve and relax: bonds broken
    integer(c_int64_t) :: broken_bonds = 0
    !> of solve and relax: share of the way to the conditions that was gone, 1 when complete
    real(c_double) :: share = 0
    !> of solve and relax: relative residual of the last iteration
    real(c_double) :: residual = 0
    !> of solve and relax: elastic energy at the end of a run that succeeded
    real(c_double) :: elastic = 0
    !> of solve and relax: work of loads and constraints
    real(c_double) :: external_work = 0
    !> of solve and relax: relative residuals, one an iteration; of many the first 100000
    real(c_double), allocatable :: residuals(:)
    !> of relax: energies of its motion over the largest that it had, one a step, as many as residuals
    real(c_double), allocatable :: energies(:)
  end type perion_report

  !> Heap bytes that a simulation holds.
  type :: perion_memory
    !> points, their order, sets, places and materials
    integer(c_int64_t) :: points = 0
    !> bonds, their state and when they break; 0 before set-up has ended
    integer(c_int64_t) :: bonds = 0
    !> displacement, velocity, acceleration, forces, dissipated energy
    integer(c_int64_t) :: state = 0
    !> all of it
    integer(c_int64_t) :: total = 0
  end type perion_memory

  !> A field in the library's own memory and inner order: component c of the host's point p is
  !> view%data(c, view%place(p)). Valid until the view is returned or the simulation destroyed.
  type :: perion_view
    !> The values (components,count); null when nothing is borrowed. Fortran cannot keep a host from
    !> writing into a view that was lent to read only: it must not.
    real(c_double), pointer :: data(:, :) => null()
    !> Inner place of each of the host's points, from 0; null when the orders are the same.
    integer(c_int64_t), pointer, private :: slot(:) => null()
    !> The view as C has it; its struct_size is 0 when nothing is borrowed.
    type(raw_view), private :: lent = raw_view(0, c_null_ptr, c_null_ptr, 0, 0, 0, 0, 0)
  contains
    generic :: place => view_place_int64, view_place_int32
    procedure, private :: view_place_int64, view_place_int32
  end type perion_view

  !> What is handed to C as a function's user pointer; it lives as long as the simulation, or until
  !> the same set, quantity and axis get another function.
  type :: function_holder
    class(perion_function), pointer :: host => null()
    integer(c_int64_t) :: dimension = 0
    character(:), allocatable :: set
    integer(c_int32_t) :: quantity = 0, axis = 0
    type(function_holder), pointer :: next => null()
  end type function_holder

  !> What is handed to C as the user pointer of a progress callback.
  type :: progress_holder
    class(perion_progress), pointer :: host => null()
    type(c_ptr) :: simulation = c_null_ptr
    integer(c_int64_t) :: dimension = 0, count = 0
  end type progress_holder

  !> What is handed to C as the user pointer of a log callback.
  type :: log_holder
    class(perion_log), pointer :: host => null()
  end type log_holder

  !> A body of points that moves under a model.
  type :: perion_simulation
    private
    type(c_ptr) :: handle = c_null_ptr
    integer(c_int64_t) :: axes = 0, points = 0
    type(function_holder), pointer :: functions => null()
    type(material_use), pointer :: materials => null()
    type(progress_holder), pointer :: progress => null()
    type(log_holder), pointer :: log => null()
  contains
    procedure :: create => simulation_create
    procedure :: assign_model => simulation_assign_model
    procedure :: set_interface => simulation_set_interface
    procedure :: forbid_failure => simulation_forbid_failure
    generic :: set_threads => set_threads_int64, set_threads_int32
    generic :: point_count => point_count_int64, point_count_int32
    generic :: dimension => dimension_int64, dimension_int32
    procedure :: destroy => simulation_destroy
    generic :: break_bonds => break_bonds_int64, break_bonds_int32
    procedure :: break_crossing => simulation_break_crossing
    generic :: set_bond_integrity => set_bond_integrity_int64, set_bond_integrity_int32
    generic :: get_bonds => get_bonds_int64, get_bonds_int32, get_bonds_without_pairs
    generic :: bond_count => bond_count_int64, bond_count_int32
    generic :: prescribe => prescribe_int64, prescribe_int32, prescribe_vector
    generic :: prescribe_table => prescribe_table_int64, prescribe_table_int32
    generic :: prescribe_function => prescribe_function_int64, prescribe_function_int32
    generic :: prescribe_values => prescribe_values_int64, prescribe_values_int32
    generic :: release => release_int64, release_int32
    generic :: get => get_vectors, get_scalars, get_tensors
    generic :: set => set_vectors, set_scalars
    generic :: sum => sum_components, sum_scalar, sum_tensor
    generic :: gradient => gradient_vectors, gradient_scalars
    generic :: divergence => divergence_tensors, divergence_vectors
    procedure :: borrow => simulation_borrow
    procedure :: borrow_const => simulation_borrow_const
    procedure :: return => simulation_return
    procedure :: evaluate => simulation_evaluate
    procedure :: commit => simulation_commit
    procedure :: stable_time_step => simulation_stable_time_step
    generic :: step => step_int64, step_int32
    procedure :: advance => simulation_advance
    procedure :: solve => simulation_solve
    procedure :: relax => simulation_relax
    procedure :: set_surface_areas => simulation_set_surface_areas
    procedure :: set_progress => simulation_set_progress
    procedure :: set_log => simulation_set_log
    procedure :: time => simulation_time
    procedure :: set_time => simulation_set_time
    generic :: step_count => step_count_int64, step_count_int32
    procedure :: energy => simulation_energy
    procedure :: health => simulation_health
    procedure :: memory => simulation_memory
    procedure :: write_vtk => simulation_write_vtk
    procedure :: write_series => simulation_write_series
    generic :: assignment(=) => simulation_assign
    procedure, private :: set_threads_int64, set_threads_int32
    procedure, private :: point_count_int64, point_count_int32
    procedure, private :: dimension_int64, dimension_int32
    procedure, private :: break_bonds_int64, break_bonds_int32
    procedure, private :: set_bond_integrity_int64, set_bond_integrity_int32
    procedure, private :: get_bonds_int64, get_bonds_int32, get_bonds_without_pairs
    procedure, private :: bond_count_int64, bond_count_int32
    procedure, private :: prescribe_int64, prescribe_int32, prescribe_vector
    procedure, private :: prescribe_table_int64, prescribe_table_int32
    procedure, private :: prescribe_function_int64, prescribe_function_int32
    procedure, private :: prescribe_values_int64, prescribe_values_int32
    procedure, private :: release_int64, release_int32
    procedure, private :: get_vectors, get_scalars, get_tensors, set_vectors, set_scalars
    procedure, private :: gradient_vectors, gradient_scalars, divergence_tensors, divergence_vectors
    procedure, private :: sum_components, sum_scalar, sum_tensor
    procedure, private :: step_int64, step_int32
    procedure, private :: step_count_int64, step_count_int32
    procedure, private :: simulation_assign
    final :: simulation_finalize
  end type perion_simulation

  !> Version of the library in use as text, '0.1.0'. As a number, 10000 major + 100 minor + patch,
  !> it is perion_version(); perion_abi_version() is that of the binary interface, to be compared
  !> with PERION_ABI_VERSION_CONSTANT.
  interface perion_version_string
    module procedure version_string
  end interface perion_version_string

  !> How the library was built, in a line.
  interface perion_build_info
    module procedure build_info
  end interface perion_build_info

  !> Whether the library has an optional feature. Known are 'threads' (it has) and 'ranks' (not
  !> yet).
  interface perion_has_feature
    module procedure has_feature
  end interface perion_has_feature

  !> Two or three words for a status number, 'unknown status' for a number that is none.
  interface perion_status_string
    module procedure status_string
  end interface perion_status_string

  !> The library's last failure on the calling thread, '' when nothing has failed; failures that
  !> this module finds, of shapes and of indices, are in `error` alone.
  interface perion_last_error
    module procedure last_error
  end interface perion_last_error

  !> Number of formulations.
  interface perion_formulation_count
    module procedure formulation_count
  end interface perion_formulation_count

  !> Number of keys that models know.
  interface perion_key_count
    module procedure key_count
  end interface perion_key_count

  !> Name of a formulation, index from 1; '' when there is none.
  interface perion_formulation_name
    module procedure formulation_name_int64, formulation_name_int32
  end interface perion_formulation_name

  !> What a formulation is, in a line; '' when there is none.
  interface perion_formulation_description
    module procedure formulation_description_int64, formulation_description_int32
  end interface perion_formulation_description

  !> Name of a key, index from 1; '' when there is none.
  interface perion_key_name
    module procedure key_name_int64, key_name_int32
  end interface perion_key_name

  !> Meaning of a key, its unit kind and the reason for its default; '' when there is none.
  interface perion_key_description
    module procedure key_description_int64, key_description_int32
  end interface perion_key_description

  !> Default of a key as text, '' where it has none.
  interface perion_key_default
    module procedure key_default_int64, key_default_int32
  end interface perion_key_default

  !> Choices of a key with a bar between them ('strain|stress'), '' for a key that takes a number.
  interface perion_key_choices
    module procedure key_choices_int64, key_choices_int32
  end interface perion_key_choices

  ! The host's callbacks.
  abstract interface

    !> Fills P (first Piola-Kirchhoff stress, (dimension,dimension,count)) and W (stored energy per
    !> reference volume, (count)) for the deformation gradients F1, F1(i,j,k) = dx_i/dX_j, and state1,
    !> which is the material's only when a step is completed or committed. F0 and state0 are those of
    !> the last committed state: F0 = I and state0 = 0 at first. States are (state_size,count); state1
    !> comes as state0. Must give the same for the same; may not call anything on the simulation. `stop`
    !> comes as false; true stops the call (ERROR_INTERRUPTED).
    subroutine perion_material_answer(self, F0, F1, state0, state1, P, W, stop)
      import :: c_double, perion_material
      class(perion_material), intent(inout) :: self
      real(c_double), intent(in) :: F0(:, :, :), F1(:, :, :)
      real(c_double), intent(in) :: state0(:, :)
      real(c_double), intent(inout) :: state1(:, :)
      real(c_double), intent(inout) :: P(:, :, :)
      real(c_double), intent(inout) :: W(:)
      logical, intent(inout) :: stop
    end subroutine perion_material_answer

    !> Fills values(count) at `time` for the points of its set, whose reference positions
    !> (dimension,count) come in the set's order. It may not call anything on the simulation. `stop`
    !> comes as false; true stops the run (ERROR_INTERRUPTED).
    subroutine perion_function_evaluate(self, time, positions, values, stop)
      import :: c_double, perion_function
      class(perion_function), intent(inout) :: self
      real(c_double), intent(in) :: time
      real(c_double), intent(in) :: positions(:, :)
      real(c_double), intent(inout) :: values(:)
      logical, intent(inout) :: stop
    end subroutine perion_function_evaluate

    !> `done` of `total` steps of this run are made, and it is `time`. The simulation is there to
    !> look at, write_vtk and write_series among what it allows. `stop` comes as false; true stops
    !> the run (ERROR_INTERRUPTED).
    subroutine perion_progress_report(self, simulation, done, total, time, stop)
      import :: c_double, c_int64_t, perion_progress, perion_simulation
      class(perion_progress), intent(inout) :: self
      type(perion_simulation), intent(in) :: simulation
      integer(c_int64_t), intent(in) :: done, total
      real(c_double), intent(in) :: time
      logical, intent(inout) :: stop
    end subroutine perion_progress_report

    !> Takes a message of the level PERION_LOG_LEVEL_WARNING or PERION_LOG_LEVEL_INFORMATION. It may
    !> not call anything on the simulation.
    subroutine perion_log_take(self, level, message)
      import :: c_int32_t, perion_log
      class(perion_log), intent(inout) :: self
      integer(c_int32_t), intent(in) :: level
      character(*), intent(in) :: message
    end subroutine perion_log_take

  end interface

  ! All procedures are recursive: callbacks may use other simulations, and threads of the host have
  ! objects of their own.

  ! The library.
  interface

    recursive module function version_string() result(text)
      character(:), allocatable :: text
    end function version_string

    recursive module function build_info() result(text)
      character(:), allocatable :: text
    end function build_info

    recursive module function has_feature(name) result(has)
      character(*), intent(in) :: name
      logical :: has
    end function has_feature

    recursive module function status_string(status) result(text)
      integer(c_int32_t), intent(in) :: status
      character(:), allocatable :: text
    end function status_string

    recursive module function last_error() result(text)
      character(:), allocatable :: text
    end function last_error

    recursive module function formulation_count() result(count)
      integer(c_int32_t) :: count
    end function formulation_count

    recursive module function key_count() result(count)
      integer(c_int32_t) :: count
    end function key_count

    recursive module function formulation_name_int64(index) result(text)
      integer(c_int64_t), intent(in) :: index
      character(:), allocatable :: text
    end function formulation_name_int64

    recursive module function formulation_name_int32(index) result(text)
      integer(c_int32_t), intent(in) :: index
      character(:), allocatable :: text
    end function formulation_name_int32

    recursive module function formulation_description_int64(index) result(text)
      integer(c_int64_t), intent(in) :: index
      character(:), allocatable :: text
    end function formulation_description_int64

    recursive module function formulation_description_int32(index) result(text)
      integer(c_int32_t), intent(in) :: index
      character(:), allocatable :: text
    end function formulation_description_int32

    recursive module function key_name_int64(index) result(text)
      integer(c_int64_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_name_int64

    recursive module function key_name_int32(index) result(text)
      integer(c_int32_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_name_int32

    recursive module function key_description_int64(index) result(text)
      integer(c_int64_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_description_int64

    recursive module function key_description_int32(index) result(text)
      integer(c_int32_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_description_int32

    recursive module function key_default_int64(index) result(text)
      integer(c_int64_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_default_int64

    recursive module function key_default_int32(index) result(text)
      integer(c_int32_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_default_int32

    recursive module function key_choices_int64(index) result(text)
      integer(c_int64_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_choices_int64

    recursive module function key_choices_int32(index) result(text)
      integer(c_int32_t), intent(in) :: index
      character(:), allocatable :: text
    end function key_choices_int32

  end interface

  ! Points.
  interface

    !> Makes points of coordinates (dimension,count), lengths, and volumes (count), in 2D areas;
    !> both are copied. Points may come in any order.
    !>
    !> ERROR_ARGUMENT: dimension not 2 or 3, no point, another number of volumes, a coordinate that
    !> is not finite, a volume that is not positive, two points in one place.
    recursive module subroutine points_create(self, coordinates, volumes, error)
      class(perion_points), intent(inout) :: self
      real(c_double), target, intent(in) :: coordinates(:, :)
      real(c_double), target, intent(in) :: volumes(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_create

    !> Makes a block of points: a lattice of cells of edge `spacing` between the corners `lower` and
    !> `upper` (one length an axis), a point in the middle of each cell, x fastest. Counts per axis
    !> are rounded; each point has the volume spacing**dimension.
    !>
    !> ERROR_ARGUMENT: not 2 or 3 axes, limits not finite or upside down, spacing not positive or
    !> too large, too many points.
    recursive module subroutine points_create_block(self, lower, upper, spacing, error)
      class(perion_points), intent(inout) :: self
      real(c_double), intent(in) :: lower(:), upper(:)
      real(c_double), intent(in) :: spacing
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_create_block

    !> Reads points from a file, whose name tells what it is: .inp (Abaqus), .msh (Gmsh 4.1 or 2.2,
    !> text or binary), .vtu (VTK), anything else text.
    !>
    !> Text: a point a line, "x y z volume", "x y z block volume", or "x y area" in 2D, with blanks
    !> or commas between; #, ! and % begin comments. A first line may name the columns, in any order and
    !> with others beside them. Blocks become sets block_1 and so on.
    !>
    !> Mesh: each cell of the highest dimension becomes a point in its centroid with its volume
    !> (plane cells: its area), in the file's order. Groups of such cells (*ELSET, physical groups)
    !> become sets; a group of nodes (*NSET), or of cells of lower dimension such as the faces of a
    !> boundary, becomes the set of the points whose cells have one of its nodes. A name that other
    !> points have already gets "_2"; a group without points is left out. get_set_name lists what
    !> came of them.
    !>
    !> A .vtu without cells, or with vertices only, is a cloud with a point array "volume"; it is 2D
    !> if all z are 0. An integer array "block" gives sets.
    !>
    !> ERROR_IO: it cannot be read. ERROR_FORMAT: it is not what it should be; the text says file
    !> and line, what was expected and what was found. ERROR_UNSUPPORTED: what points cannot
    !> express, such as includes and instances of Abaqus, or curved shells.
    recursive module subroutine points_read(self, path, error)
      class(perion_points), intent(inout) :: self
      character(*), intent(in) :: path
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_read

    !> Gives each point its own horizon (count), a length, in place of the model's.
    !>
    !> ERROR_ARGUMENT: another number of horizons, a horizon that is not positive.
    recursive module subroutine points_set_horizons(self, horizons, error)
      class(perion_points), intent(inout) :: self
      real(c_double), target, intent(in) :: horizons(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_set_horizons

    !> Names a set of points by their indices, whose order it keeps. The set 'all' exists from the
    !> start.
    !>
    !> ERROR_ARGUMENT: name empty, taken, longer than 255 bytes or with control characters, no
    !> index, one out of range or given twice.
    recursive module subroutine points_add_set_int64(self, name, indices, error)
      class(perion_points), intent(inout) :: self
      character(*), intent(in) :: name
      integer(c_int64_t), intent(in) :: indices(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_add_set_int64

    recursive module subroutine points_add_set_int32(self, name, indices, error)
      class(perion_points), intent(inout) :: self
      character(*), intent(in) :: name
      integer(c_int32_t), intent(in) :: indices(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_add_set_int32

    !> Names the set of the points within a box, its faces included, in the order of the points.
    !> lower and upper: one length an axis; infinite ones leave a side open.
    !>
    !> ERROR_ARGUMENT: as add_set; a box upside down or without points.
    recursive module subroutine points_add_set_box(self, name, lower, upper, error)
      class(perion_points), intent(inout) :: self
      character(*), intent(in) :: name
      real(c_double), intent(in) :: lower(:), upper(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_add_set_box

    !> Number of points.
    recursive module subroutine points_count_int64(self, count, error)
      class(perion_points), intent(in) :: self
      integer(c_int64_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_count_int64

    recursive module subroutine points_count_int32(self, count, error)
      class(perion_points), intent(in) :: self
      integer(c_int32_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_count_int32

    !> Number of axes, 2 or 3.
    recursive module subroutine points_dimension_int64(self, dimension, error)
      class(perion_points), intent(in) :: self
      integer(c_int64_t), intent(inout) :: dimension
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_dimension_int64

    recursive module subroutine points_dimension_int32(self, dimension, error)
      class(perion_points), intent(in) :: self
      integer(c_int32_t), intent(inout) :: dimension
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_dimension_int32

    !> Number of named sets; 'all', which always exists, is not among them.
    recursive module subroutine points_set_count_int64(self, count, error)
      class(perion_points), intent(in) :: self
      integer(c_int64_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_set_count_int64

    recursive module subroutine points_set_count_int32(self, count, error)
      class(perion_points), intent(in) :: self
      integer(c_int32_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_set_count_int32

    !> Name of a set; index: from 1, in alphabetical order. ERROR_ARGUMENT: index out of range.
    recursive module subroutine points_get_set_name_int64(self, index, name, error)
      class(perion_points), intent(in) :: self
      integer(c_int64_t), intent(in) :: index
      character(:), allocatable, intent(inout) :: name
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_get_set_name_int64

    recursive module subroutine points_get_set_name_int32(self, index, name, error)
      class(perion_points), intent(in) :: self
      integer(c_int32_t), intent(in) :: index
      character(:), allocatable, intent(inout) :: name
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_get_set_name_int32

    !> Number of points of a set. ERROR_ARGUMENT: no such set.
    recursive module subroutine points_set_size_int64(self, name, count, error)
      class(perion_points), intent(in) :: self
      character(*), intent(in) :: name
      integer(c_int64_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_set_size_int64

    recursive module subroutine points_set_size_int32(self, name, count, error)
      class(perion_points), intent(in) :: self
      character(*), intent(in) :: name
      integer(c_int32_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_set_size_int32

    !> The indices of a set, in its order; as many as set_size says. ERROR_ARGUMENT: no such set.
    recursive module subroutine points_get_set_int64(self, name, indices, error)
      class(perion_points), intent(in) :: self
      character(*), intent(in) :: name
      integer(c_int64_t), intent(inout) :: indices(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_get_set_int64

    recursive module subroutine points_get_set_int32(self, name, indices, error)
      class(perion_points), intent(in) :: self
      character(*), intent(in) :: name
      integer(c_int32_t), intent(inout) :: indices(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_get_set_int32

    !> The positions of all points (dimension,count), lengths.
    recursive module subroutine points_get_coordinates(self, coordinates, error)
      class(perion_points), intent(in) :: self
      real(c_double), target, intent(inout) :: coordinates(:, :)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_get_coordinates

    !> The volumes of all points (count); in 2D areas.
    recursive module subroutine points_get_volumes(self, volumes, error)
      class(perion_points), intent(in) :: self
      real(c_double), intent(inout) :: volumes(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_get_volumes

    !> Frees the points; none is fine. ERROR_STATE: another call is using them.
    recursive module subroutine points_destroy(self, error)
      class(perion_points), intent(inout) :: self
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine points_destroy

    !> Stops the program: points do not copy. Two that have not been created may meet.
    impure elemental recursive module subroutine points_assign(left, right)
      class(perion_points), intent(inout) :: left
      class(perion_points), intent(in) :: right
    end subroutine points_assign

    recursive module subroutine points_free(self)
      type(perion_points), intent(inout) :: self
    end subroutine points_free

  end interface

  ! Models.
  interface

    !> Makes a model of a formulation ('bond_based'), with nothing set. ERROR_ARGUMENT: unknown
    !> formulation; the text names a similar one.
    recursive module subroutine model_create(self, formulation, error)
      class(perion_model), intent(inout) :: self
      character(*), intent(in) :: formulation
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine model_create

    !> Sets a number; perion_key_name lists the keys. Values are checked one by one here, and
    !> together when a simulation is made.
    !>
    !> ERROR_ARGUMENT: unknown key (the text names a similar one), a key that takes a choice, a
    !> value out of its range. ERROR_UNSUPPORTED: a key the formulation does not take.
    recursive module subroutine model_set(self, key, value, error)
      class(perion_model), intent(inout) :: self
      character(*), intent(in) :: key
      real(c_double), intent(in) :: value
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine model_set

    !> The number last set for a key, or its default.
    !>
    !> ERROR_ARGUMENT: unknown key, or one that takes a choice. ERROR_STATE: not set, and without a
    !> default.
    recursive module subroutine model_get(self, key, value, error)
      class(perion_model), intent(in) :: self
      character(*), intent(in) :: key
      real(c_double), intent(inout) :: value
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine model_get

    !> Makes a choice; perion_key_choices lists them.
    !>
    !> ERROR_ARGUMENT: unknown key or choice, or a key that takes a number. ERROR_UNSUPPORTED: a key
    !> the formulation does not take.
    recursive module subroutine model_choose(self, key, choice, error)
      class(perion_model), intent(inout) :: self
      character(*), intent(in) :: key, choice
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine model_choose

    !> Takes a law of the host's own in place of `material`, with state_size numbers of state at each
    !> place where the formulation asks its law: points, or bonds from both ends. Elastic constants are
    !> still needed. The object is not copied: it must have the attribute target (or be what a pointer
    !> points to) and live where it is until the model, and the simulations made of it, are destroyed;
    !> they share it, and it is asked by the thread that drives each. In 2D the law answers for what
    !> lies across, and STRESS_33 and VON_MISES_STRESS are ERROR_UNSUPPORTED. Where a family does not
    !> span the body F has what is missing turned along, without stretch, and P counts in the directions
    !> spanned. Simulations of one model with a law have points of one dimension.
    !>
    !> ERROR_ARGUMENT: state_size below 0 or above 100000. ERROR_UNSUPPORTED: a formulation that asks no
    !> law.
    recursive module subroutine set_material_function_int64(self, state_size, material, error)
      class(perion_model), intent(inout) :: self
      integer(c_int64_t), intent(in) :: state_size
      class(perion_material), target, intent(inout) :: material
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_material_function_int64

    recursive module subroutine set_material_function_int32(self, state_size, material, error)
      class(perion_model), intent(inout) :: self
      integer(c_int32_t), intent(in) :: state_size
      class(perion_material), target, intent(inout) :: material
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_material_function_int32

    !> Whether a simulation of points of a dimension can use a material function; it does from then on.
    recursive module function material_taken(holder, dimension, call, error) result(taken)
      type(material_holder), pointer, intent(in) :: holder
      integer(c_int64_t), intent(in) :: dimension
      character(*), intent(in) :: call
      type(perion_error), allocatable, optional, intent(inout) :: error
      logical :: taken
    end function material_taken

    !> A simulation, or else its model, needs a material function no more.
    recursive module subroutine leave_material(holder, is_model)
      type(material_holder), pointer, intent(inout) :: holder
      logical, intent(in) :: is_model
    end subroutine leave_material

    !> Frees a model; none is fine. ERROR_STATE: another call is using it.
    recursive module subroutine model_destroy(self, error)
      class(perion_model), intent(inout) :: self
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine model_destroy

    !> Stops the program: models do not copy. Two that have not been created may meet.
    impure elemental recursive module subroutine model_assign(left, right)
      class(perion_model), intent(inout) :: left
      class(perion_model), intent(in) :: right
    end subroutine model_assign

    recursive module subroutine model_free(self)
      type(perion_model), intent(inout) :: self
    end subroutine model_free

  end interface

  ! Simulations: set-up.
  interface

    !> Brings points and a model together; both are copied and can be destroyed or used again.
    !>
    !> What follows is set-up, until the first call that needs the bonds: evaluate, commit, step,
    !> stable_time_step, energy, health, bond_count, get_bonds, borrow and borrow_const, write_vtk and
    !> write_series with such fields, or a get or sum of anything but positions, displacement,
    !> velocity and body force. Only then a horizon that reaches no neighbour is found.
    !>
    !> ERROR_ARGUMENT: the model lacks density, horizon or an elastic constant, or holds what does
    !> not fit together or to the dimension.
    recursive module subroutine simulation_create(self, points, model, error)
      class(perion_simulation), intent(inout) :: self
      class(perion_points), intent(in) :: points
      class(perion_model), intent(in) :: model
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_create

    !> Gives the points of a set another material. All models of a simulation share the formulation
    !> and, in 2D, the plane state. Belongs to set-up (see create).
    !>
    !> ERROR_ARGUMENT: unknown set, or a model that could not stand alone. ERROR_UNSUPPORTED:
    !> another formulation or plane state. ERROR_STATE: set-up has ended.
    recursive module subroutine simulation_assign_model(self, set, model, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      class(perion_model), intent(in) :: model
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_assign_model

    !> Gives the bonds between two sets a critical energy release rate of their own (energy per
    !> area). Belongs to set-up (see create).
    !>
    !> ERROR_ARGUMENT: unknown set, a rate that is not positive. ERROR_STATE: set-up has ended.
    recursive module subroutine simulation_set_interface(self, set_a, set_b, &
        critical_energy_release_rate, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set_a, set_b
      real(c_double), intent(in) :: critical_energy_release_rate
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_set_interface

    !> Lets no bond break by its stretch that has an end in the set; the host can still break it.
    !> ERROR_ARGUMENT: unknown set.
    recursive module subroutine simulation_forbid_failure(self, set, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_forbid_failure

    !> Sets the number of threads, 1 to 4096. Results do not depend on it, to the last bit. The
    !> default is PERION_NUM_THREADS, else OMP_NUM_THREADS, else all cores.
    !>
    !> ERROR_ARGUMENT: out of range. ERROR_STATE: the threads could not be started.
    recursive module subroutine set_threads_int64(self, threads, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int64_t), intent(in) :: threads
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_threads_int64

    recursive module subroutine set_threads_int32(self, threads, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int32_t), intent(in) :: threads
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_threads_int32

    !> Number of points.
    recursive module subroutine point_count_int64(self, count, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int64_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine point_count_int64

    recursive module subroutine point_count_int32(self, count, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine point_count_int32

    !> Number of axes, 2 or 3.
    recursive module subroutine dimension_int64(self, dimension, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int64_t), intent(inout) :: dimension
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine dimension_int64

    recursive module subroutine dimension_int32(self, dimension, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(inout) :: dimension
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine dimension_int32

    !> Frees a simulation and ends its threads; none is fine. Views that are still borrowed end with
    !> it. ERROR_STATE: another call is using it, such as the one whose callback this is.
    recursive module subroutine simulation_destroy(self, error)
      class(perion_simulation), intent(inout) :: self
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_destroy

    !> Stops the program: simulations do not copy. Two that have not been created may meet.
    impure elemental recursive module subroutine simulation_assign(left, right)
      class(perion_simulation), intent(inout) :: left
      class(perion_simulation), intent(in) :: right
    end subroutine simulation_assign

    recursive module subroutine simulation_free(self)
      type(perion_simulation), intent(inout) :: self
    end subroutine simulation_free

  end interface

  ! Simulations: bonds.
  interface

    !> Breaks the bonds of pairs (2,count) of points for good. Pairs without a bond are passed over,
    !> and told to the log. Allowed at any time; what the bonds held is dissipated.
    !>
    !> ERROR_ARGUMENT: an index out of range, a point paired with itself.
    recursive module subroutine break_bonds_int64(self, pairs, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int64_t), intent(in) :: pairs(:, :)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine break_bonds_int64

    recursive module subroutine break_bonds_int32(self, pairs, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int32_t), intent(in) :: pairs(:, :)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine break_bonds_int32

    !> Breaks every bond that crosses a planar polygon (3D, at least 3 vertices) or a segment (2D, 2
    !> vertices) for good. vertices: (dimension,vertex_count) lengths in the reference
    !> configuration. Points within 1e-9 spacings of the plane (or what the rounding of large
    !> coordinates amounts to) belong to its positive side: where the vertices are seen to run
    !> counter-clockwise, in 2D to the left of the segment. The rim belongs to the crack; bonds
    !> within the plane stay. A crack that no bond crosses is told to the log.
    !>
    !> ERROR_ARGUMENT: too few or too many vertices, ones not finite or not in a plane, no extent.
    recursive module subroutine simulation_break_crossing(self, vertices, error)
      class(perion_simulation), intent(inout) :: self
      real(c_double), intent(in) :: vertices(:, :)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_break_crossing

    !> Sets the integrity of the bonds of pairs (2,count) of points: values (count), 1 intact, 0
    !> broken. A broken bond stays broken; pairs without a bond are passed over, and told to the
    !> log. Allowed at any time: what bonds lose is dissipated, what they gain given by the host.
    !>
    !> ERROR_ARGUMENT: an index out of range, a point paired with itself, a value outside 0 to 1.
    recursive module subroutine set_bond_integrity_int64(self, pairs, values, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int64_t), intent(in) :: pairs(:, :)
      real(c_double), target, intent(in) :: values(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_bond_integrity_int64

    recursive module subroutine set_bond_integrity_int32(self, pairs, values, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int32_t), intent(in) :: pairs(:, :)
      real(c_double), target, intent(in) :: values(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_bond_integrity_int32

    !> Lists all bonds, broken ones too, each once: pairs (2,count), stretch (count) at the current
    !> displacement, integrity (count), 1 intact, 0 broken. Each of the three may be left out.
    !> count: as bond_count says; in longer arrays the rest is not touched.
    !>
    !> ERROR_ARGUMENT: arrays too short, or of different lengths.
    recursive module subroutine get_bonds_int64(self, pairs, stretch, integrity, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int64_t), intent(inout) :: pairs(:, :)
      real(c_double), optional, intent(inout) :: stretch(:), integrity(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine get_bonds_int64

    recursive module subroutine get_bonds_int32(self, pairs, stretch, integrity, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(inout) :: pairs(:, :)
      real(c_double), optional, intent(inout) :: stretch(:), integrity(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine get_bonds_int32

    recursive module subroutine get_bonds_without_pairs(self, stretch, integrity, error)
      class(perion_simulation), intent(in) :: self
      real(c_double), optional, intent(inout) :: stretch(:), integrity(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine get_bonds_without_pairs

    !> Number of bonds, broken or not, each counted once.
    recursive module subroutine bond_count_int64(self, count, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int64_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine bond_count_int64

    recursive module subroutine bond_count_int32(self, count, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine bond_count_int32

  end interface

  ! Simulations: conditions.
  interface

    !> Prescribes a constant on a set along an axis, from the next step on. Per point and axis the
    !> last displacement or velocity wins and replaces the other for good; body forces of different
    !> sets add, the same set and axis replaces. A displacement is where the point is put at once at
    !> the end of the next step: ramp it by a table for smooth loading.
    !>
    !> ERROR_ARGUMENT: unknown set or quantity, axis out of range, value not finite.
    recursive module subroutine prescribe_int64(self, set, quantity, axis, value, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int64_t), intent(in) :: axis
      real(c_double), intent(in) :: value
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_int64

    recursive module subroutine prescribe_int32(self, set, quantity, axis, value, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int32_t), intent(in) :: axis
      real(c_double), intent(in) :: value
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_int32

    !> Prescribes constants on a set along all axes: values (dimension), axis by axis as above.
    !>
    !> ERROR_ARGUMENT: as above; another number of values.
    recursive module subroutine prescribe_vector(self, set, quantity, values, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      real(c_double), intent(in) :: values(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_vector

    !> Prescribes a table over time: linear between its times, constant outside. times (count),
    !> increasing, and values (count); both are copied.
    !>
    !> ERROR_ARGUMENT: as prescribe; no time, times that do not increase.
    recursive module subroutine prescribe_table_int64(self, set, quantity, axis, times, values, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int64_t), intent(in) :: axis
      real(c_double), target, intent(in) :: times(:), values(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_table_int64

    recursive module subroutine prescribe_table_int32(self, set, quantity, axis, times, values, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int32_t), intent(in) :: axis
      real(c_double), target, intent(in) :: times(:), values(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_table_int32

    !> Prescribes a function of time and place, asked once per time that a step needs: displacements
    !> at the step's end, velocities at its middle and end, body forces at its end (and at the first
    !> step's beginning). The object is not copied: it must have the attribute target (or be what a
    !> pointer points to) and live where it is until the simulation is destroyed, or the same set,
    !> quantity and axis get another condition or are released.
    !>
    !> ERROR_ARGUMENT: as prescribe. A value that is not finite ends a later step with
    !> ERROR_NUMERIC.
    recursive module subroutine prescribe_function_int64(self, set, quantity, axis, function, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int64_t), intent(in) :: axis
      class(perion_function), target, intent(inout) :: function
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_function_int64

    recursive module subroutine prescribe_function_int32(self, set, quantity, axis, function, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int32_t), intent(in) :: axis
      class(perion_function), target, intent(inout) :: function
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_function_int32

    !> Prescribes values (count), one a point of the set, in the set's order; copied and held until
    !> replaced.
    !>
    !> ERROR_ARGUMENT: as prescribe; count is not the set's size.
    recursive module subroutine prescribe_values_int64(self, set, quantity, axis, values, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int64_t), intent(in) :: axis
      real(c_double), target, intent(in) :: values(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_values_int64

    recursive module subroutine prescribe_values_int32(self, set, quantity, axis, values, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int32_t), intent(in) :: axis
      real(c_double), target, intent(in) :: values(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine prescribe_values_int32

    !> Ends what was prescribed on a set along an axis; the points are free there from the next step
    !> on.
    !>
    !> ERROR_ARGUMENT: nothing is prescribed there, or other sets have taken all its points.
    recursive module subroutine release_int64(self, set, quantity, axis, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int64_t), intent(in) :: axis
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine release_int64

    recursive module subroutine release_int32(self, set, quantity, axis, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      integer(c_int32_t), intent(in) :: quantity
      integer(c_int32_t), intent(in) :: axis
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine release_int32

  end interface

  ! Simulations: fields.
  interface

    !> Copies a field to the host: vectors to (dimension,count), tensors to
    !> (dimension,dimension,count), all others to (count); all points in the host's order, or those
    !> of a set in the set's. values(i,j,k) is component i, j of point k, such as
    !> F(i,j) = dx(i)/dX(j): row and column as on paper, where C has them row after row. Derived
    !> fields are computed when asked for.
    !>
    !> ERROR_ARGUMENT: unknown field or set, another shape. ERROR_STATE: ACCELERATION, REACTION or
    !> BODY_FORCE of conditions after a change of state or conditions; evaluate first.
    !> ERROR_NUMERIC: a force, deformation or stress that is not finite. ERROR_UNSUPPORTED: STRESS_33
    !> in 3D.
    recursive module subroutine get_vectors(self, field, values, set, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), target, intent(inout) :: values(:, :)
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine get_vectors

    recursive module subroutine get_scalars(self, field, values, set, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), target, intent(inout) :: values(:)
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine get_scalars

    recursive module subroutine get_tensors(self, field, values, set, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), intent(inout) :: values(:, :, :)
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine get_tensors

    !> The gradient of a field of the host's over the families of the simulation at its current
    !> displacement, w the influence function, broken bonds left out: of field(components,count)
    !> result(components,dimension,count), result(i,j,k) = d field(i)/d x(j) at point k; of
    !> field(count) result(dimension,count). All points, in the host's order. The PERION_OPERATOR_
    !> constants say what it is differentiated by, and with which bonds. A point without bonds has 0;
    !> where the bonds of a point do not span the body, the derivative is that along what they span.
    !> Ends set-up.
    !>
    !> ERROR_ARGUMENT: unknown operator, another shape, a number that is not finite. ERROR_NUMERIC: a
    !> derivative that is not finite.
    recursive module subroutine gradient_vectors(self, operator, field, result, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: operator
      real(c_double), intent(in) :: field(:, :)
      real(c_double), intent(inout) :: result(:, :, :)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine gradient_vectors

    recursive module subroutine gradient_scalars(self, operator, field, result, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: operator
      real(c_double), intent(in) :: field(:)
      real(c_double), intent(inout) :: result(:, :)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine gradient_scalars

    !> The divergence of a field of the host's, as gradient: of tensors field(rows,dimension,count),
    !> of the shape of FIRST_PIOLA_STRESS, result(rows,count); of vectors field(dimension,count)
    !> result(count).
    recursive module subroutine divergence_tensors(self, operator, field, result, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: operator
      real(c_double), intent(in) :: field(:, :, :)
      real(c_double), intent(inout) :: result(:, :)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine divergence_tensors

    recursive module subroutine divergence_vectors(self, operator, field, result, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: operator
      real(c_double), intent(in) :: field(:, :)
      real(c_double), intent(inout) :: result(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine divergence_vectors

    !> Sets DISPLACEMENT, POSITION, VELOCITY or the host's BODY_FORCE from values (dimension,count),
    !> of all points in the host's order, or those of a set in the set's. Nothing is set unless all
    !> values are finite.
    !>
    !> ERROR_ARGUMENT: unknown field or set, another shape, a value that is not finite.
    !> ERROR_UNSUPPORTED: a field that cannot be set.
    recursive module subroutine set_vectors(self, field, values, set, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), target, intent(in) :: values(:, :)
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_vectors

    recursive module subroutine set_scalars(self, field, values, set, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), target, intent(in) :: values(:)
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine set_scalars

    !> Sums a field over a set, or over all points: vectors into components (dimension), tensors
    !> into (dimension,dimension), all others into one number. A force-displacement curve is the sum of REACTION over the held end, step by
    !> step.
    !>
    !> ERROR_ARGUMENT: unknown field or set, another shape; otherwise as get.
    recursive module subroutine sum_components(self, field, components, set, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), intent(inout) :: components(:)
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine sum_components

    recursive module subroutine sum_scalar(self, field, components, set, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), intent(inout) :: components
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine sum_scalar

    recursive module subroutine sum_tensor(self, field, components, set, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: field
      real(c_double), intent(inout) :: components(:, :)
      character(*), optional, intent(in) :: set
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine sum_tensor

    !> Lends the host DISPLACEMENT, VELOCITY or its own BODY_FORCE to read and write. Until all
    !> views are returned, calls that change the simulation give ERROR_STATE.
    !>
    !> ERROR_ARGUMENT: unknown field. ERROR_STATE: the view holds a field on loan. ERROR_UNSUPPORTED:
    !> a field that cannot be lent.
    recursive module subroutine simulation_borrow(self, field, view, error)
      class(perion_simulation), intent(inout) :: self
      integer(c_int32_t), intent(in) :: field
      type(perion_view), intent(inout) :: view
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_borrow

    !> Lends the host DISPLACEMENT, VELOCITY, ACCELERATION or INTERNAL_FORCE to read only. A run of
    !> steps ends with ERROR_STATE when its progress callback has borrowed a view and not returned
    !> it.
    !>
    !> ERROR_ARGUMENT: unknown field. ERROR_STATE: ACCELERATION or INTERNAL_FORCE after a change;
    !> evaluate first; or the view holds a field on loan. ERROR_UNSUPPORTED: a field that is computed
    !> when asked for; get it.
    recursive module subroutine simulation_borrow_const(self, field, view, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(in) :: field
      type(perion_view), intent(inout) :: view
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_borrow_const

    !> Returns a borrowed view and clears it. One that was lent to read only can be returned in a
    !> progress callback too.
    !>
    !> ERROR_ARGUMENT: not a view that this simulation has lent and not yet got back. ERROR_NUMERIC:
    !> the host has written a value that is not finite (the text names the point); the view stays
    !> borrowed, mend it and return it again.
    recursive module subroutine simulation_return(self, view, error)
      class(perion_simulation), intent(in) :: self
      type(perion_view), intent(inout) :: view
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_return

    !> Where in view%data one of the host's points stands.
    elemental recursive module function view_place_int64(self, point) result(place)
      class(perion_view), intent(in) :: self
      integer(c_int64_t), intent(in) :: point
      integer(c_int64_t) :: place
    end function view_place_int64

    elemental recursive module function view_place_int32(self, point) result(place)
      class(perion_view), intent(in) :: self
      integer(c_int32_t), intent(in) :: point
      integer(c_int64_t) :: place
    end function view_place_int32

  end interface

  ! Simulations: drive.
  interface

    !> Computes the internal force at the current displacement with bonds as they are, and from it
    !> and the loads at the current time acceleration and reactions. Breaks nothing, advances
    !> nothing.
    !>
    !> ERROR_ARGUMENT: the horizon reaches no neighbour. ERROR_NUMERIC: a force that is not finite;
    !> the text names the point. ERROR_INTERRUPTED: a function stopped.
    recursive module subroutine simulation_evaluate(self, error)
      class(perion_simulation), intent(inout) :: self
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_evaluate

    !> Accepts the current displacement as a completed step of a host that steps itself: breaks the
    !> bonds stretched beyond their limit, adds up what they held, and moves the clock on by
    !> time_step (0 is allowed). For velocity Verlet: set the displacement, commit, evaluate.
    !>
    !> ERROR_ARGUMENT: time_step negative or not finite. ERROR_NUMERIC.
    recursive module subroutine simulation_commit(self, time_step, error)
      class(perion_simulation), intent(inout) :: self
      real(c_double), intent(in) :: time_step
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_commit

    !> A time step at which step is stable near the current displacement, with bonds as they are: 2 over the
    !> largest frequency of the forces as they are linear there, less a margin: 2 to 5 percent below the
    !> limit. Materials that flow count with their elastic stiffness. huge() where no bond acts. Leaves the
    !> state as it is; ends set-up.
    !>
    !> It costs up to sixty forces, and ten when nothing has changed since it was last asked for than that a
    !> few bonds have broken. Strains, turns and damage change it: ask again as they grow, or take a part of
    !> it (0.8; half of it where bonds stretch by a tenth and more), or let advance see to it. It promises
    !> nothing for bonds pressed to a fraction of their length: see smallest_stretch of perion_health. Where
    !> forces have no potential (strong forms, deformed bonds, literal forces, laws with memory and those of
    !> the host) it follows from the eigenvalue of the largest size and is no guarantee: see
    !> stable_step_is_guaranteed of perion_health.
    !>
    !> ERROR_ARGUMENT: the horizon reaches no neighbour. ERROR_NUMERIC: forces at the current
    !> displacement are not finite, or no step is stable. ERROR_INTERRUPTED: a function stopped.
    recursive module subroutine simulation_stable_time_step(self, time_step, error)
      class(perion_simulation), intent(inout) :: self
      real(c_double), intent(inout) :: time_step
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_stable_time_step

    !> Makes `steps` velocity Verlet steps: predict, break bonds, force, correct. A failure leaves
    !> the simulation as the last completed step left it; step_count says which. Above the stable
    !> step it warns through the log and in health. The first call looks whether it is, and calls with
    !> a larger step or after bonds have changed: where forces are the slope of an energy that takes
    !> some 5 forces at a hundredth of the stable step, 20 at half of it, up to 60 near it.
    !>
    !> ERROR_ARGUMENT: time_step not positive and finite or more than 10 times the stable one, steps
    !> below 0. ERROR_NUMERIC: a motion that is not finite; the text names the point.
    !> ERROR_INTERRUPTED: a callback stopped.
    recursive module subroutine step_int64(self, time_step, steps, error)
      class(perion_simulation), intent(inout) :: self
      real(c_double), intent(in) :: time_step
      integer(c_int64_t), intent(in) :: steps
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine step_int64

    recursive module subroutine step_int32(self, time_step, steps, error)
      class(perion_simulation), intent(inout) :: self
      real(c_double), intent(in) :: time_step
      integer(c_int32_t), intent(in) :: steps
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine step_int32

    !> Makes velocity Verlet steps up to the time `until`, and lands on it exactly. Steps are a share of the
    !> stable step, which is found anew on the way; without options the defaults hold. The report tells what
    !> was done, also of a run that failed on its way. An object of set_progress is told of each step, with
    !> the total as it looks then.
    !>
    !> ERROR_ARGUMENT: until not finite or before the current time, safety outside 0 to 1,
    !> largest_time_step or interval below 0. ERROR_NUMERIC: a motion that is not finite, no step that is
    !> stable. ERROR_INTERRUPTED: a callback stopped. A failure leaves the simulation as the last
    !> completed step left it.
    recursive module subroutine simulation_advance(self, until, options, report, error)
      class(perion_simulation), intent(inout) :: self
      real(c_double), intent(in) :: until
      type(perion_advance_options), optional, intent(in) :: options
      type(perion_report), optional, intent(inout) :: report
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_advance

    !> Finds the equilibrium under the conditions by Newton's method on the forces, going on from the last
    !> completed step. Constants go linearly from what they were at the last equilibrium to what they
    !> are, tables and functions are asked along the time to options%time_end. Bonds that an equilibrium
    !> would break are broken for good, and it is looked for again. Each load step counts as a completed
    !> step, at which the body is at rest and materials remember. The report tells what was done, also of
    !> a run that failed on its way. The object of set_progress is told of each load step.
    !>
    !> ERROR_ARGUMENT: an option out of range. ERROR_STATE: a velocity is prescribed. ERROR_CONVERGENCE:
    !> load steps were cut to the smallest without success; the text has reason and residuals.
    !> ERROR_INTERRUPTED: a callback stopped. A failure leaves the simulation as the last completed load
    !> step left it.
    recursive module subroutine simulation_solve(self, options, report, error)
      class(perion_simulation), intent(inout) :: self
      type(perion_solve_options), optional, intent(in) :: options
      type(perion_report), optional, intent(inout) :: report
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_solve

    !> Finds the equilibrium under the conditions at the current time by adaptive dynamic relaxation: a
    !> damped motion with masses of its own, of one force a step, for bodies whose linear systems are hard
    !> to solve. The result counts as one completed step, at which the body is at rest; the time stands
    !> still. The object of set_progress is told after each force of the motion how many steps it has
    !> made and, as the total, may come to, as it looks then; it sees the body as it was, in the last call at
    !> rest. The log hears of the residual every hundred steps. The report tells what was done, also of a run that failed on its way.
    !>
    !> ERROR_ARGUMENT: an option out of range. ERROR_STATE: a velocity is prescribed. ERROR_CONVERGENCE:
    !> the steps did not lead there. ERROR_INTERRUPTED: a callback stopped. A failure leaves the simulation as the last completed step left it.
    recursive module subroutine simulation_relax(self, options, report, error)
      class(perion_simulation), intent(inout) :: self
      type(perion_relax_options), optional, intent(in) :: options
      type(perion_report), optional, intent(inout) :: report
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_relax

    !> Gives the areas of the surface along a set, one a point of the set, in its order: a traction then
    !> makes a force of a point's area times its value, spread over the layers below the point. Without
    !> areas they are estimated, well on lattices; give them for clouds without order and for bodies
    !> thinner than four horizons.
    !>
    !> ERROR_ARGUMENT: unknown set, not one area a point, an area not positive and finite.
    recursive module subroutine simulation_set_surface_areas(self, set, areas, error)
      class(perion_simulation), intent(inout) :: self
      character(*), intent(in) :: set
      real(c_double), target, intent(in) :: areas(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_set_surface_areas

    !> Sets the object that step, advance, solve and relax tell of their progress; none when left out. The
    !> object is not copied: it must have the attribute target (or be what a pointer points to) and live where it
    !> is until the simulation is destroyed or has another one.
    recursive module subroutine simulation_set_progress(self, progress, error)
      class(perion_simulation), intent(inout) :: self
      class(perion_progress), target, optional, intent(inout) :: progress
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_set_progress

    !> Sets the object that takes messages; none when left out (the default: silence). For the
    !> object the same holds as for set_progress.
    recursive module subroutine simulation_set_log(self, log, error)
      class(perion_simulation), intent(inout) :: self
      class(perion_log), target, optional, intent(inout) :: log
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_set_log

    !> Time of the last completed step.
    recursive module subroutine simulation_time(self, time, error)
      class(perion_simulation), intent(in) :: self
      real(c_double), intent(inout) :: time
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_time

    !> Sets the clock, along which tables and functions are asked. ERROR_ARGUMENT: not finite.
    recursive module subroutine simulation_set_time(self, time, error)
      class(perion_simulation), intent(inout) :: self
      real(c_double), intent(in) :: time
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_set_time

    !> Number of completed steps, commits included.
    recursive module subroutine step_count_int64(self, count, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int64_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine step_count_int64

    recursive module subroutine step_count_int32(self, count, error)
      class(perion_simulation), intent(in) :: self
      integer(c_int32_t), intent(inout) :: count
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine step_count_int32

    !> The energy balance; costs a sweep over the bonds. Ends set-up.
    recursive module subroutine simulation_energy(self, energy, error)
      class(perion_simulation), intent(in) :: self
      type(perion_energy), intent(inout) :: energy
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_energy

    !> What to look at before trusting a result: isolated and detached points, broken bonds, time
    !> step, compressed bonds. Costs a sweep over the bonds; ends set-up.
    !>
    !> ERROR_ARGUMENT: the horizon reaches no neighbour.
    recursive module subroutine simulation_health(self, health, error)
      class(perion_simulation), intent(in) :: self
      type(perion_health), intent(inout) :: health
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_health

    !> Heap bytes held.
    recursive module subroutine simulation_memory(self, memory, error)
      class(perion_simulation), intent(in) :: self
      type(perion_memory), intent(inout) :: memory
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_memory

    !> Writes the current positions and fields as a .vtu file for ParaView; an older file is
    !> replaced as a whole, or kept when this fails.
    !> Vectors have 3 numbers and tensors 9, row after row; what a 2D body does not have of them is 0.
    !>
    !> ERROR_IO: it cannot be written. ERROR_ARGUMENT: unknown field, or one named twice; otherwise
    !> as get.
    recursive module subroutine simulation_write_vtk(self, path, fields, error)
      class(perion_simulation), intent(in) :: self
      character(*), intent(in) :: path
      integer(c_int32_t), optional, intent(in) :: fields(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_write_vtk

    !> Writes the next .vtu of a series, NAME_000000.vtu and so on, beside NAME.pvd, which lists
    !> them with their times and is what to open in ParaView. The series starts anew with each
    !> simulation.
    !>
    !> ERROR_ARGUMENT: pvd_path does not end in .pvd; otherwise as write_vtk.
    recursive module subroutine simulation_write_series(self, pvd_path, fields, error)
      class(perion_simulation), intent(in) :: self
      character(*), intent(in) :: pvd_path
      integer(c_int32_t), optional, intent(in) :: fields(:)
      type(perion_error), allocatable, optional, intent(out) :: error
    end subroutine simulation_write_series

  end interface

contains

  ! Of the module itself, since flang 16 takes no separate procedure as a final one.

  impure elemental recursive subroutine points_finalize(self)
    type(perion_points), intent(inout) :: self

    call points_free(self)
  end subroutine points_finalize

  impure elemental recursive subroutine model_finalize(self)
    type(perion_model), intent(inout) :: self

    call model_free(self)
  end subroutine model_finalize

  impure elemental recursive subroutine simulation_finalize(self)
    type(perion_simulation), intent(inout) :: self

    call simulation_free(self)
  end subroutine simulation_finalize

end module perion
