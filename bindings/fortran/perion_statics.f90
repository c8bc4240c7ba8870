!> Simulations: equilibria, and surfaces under tractions.
submodule (perion) statics_procedures
  use, intrinsic :: iso_c_binding
  use perion_c, only: perion_relax_options_init, perion_report_init, perion_simulation_relax, &
      perion_simulation_set_surface_areas, perion_simulation_solve, perion_solve_options_init, &
      raw_relax => perion_relax_options, raw_report => perion_report, &
      raw_solve => perion_solve_options
  use perion_support
  implicit none

  !> Most residuals that a report lists.
  integer(c_int64_t), parameter :: most_residuals = 100000

contains

  module procedure simulation_solve
    type(raw_solve) :: asked
    type(raw_report) :: told
    real(c_double), allocatable, target :: residuals(:), energies(:)
    integer(c_int32_t) :: status

    call perion_solve_options_init(asked, c_sizeof(asked))
    if (present(options)) then
      asked%time_end = options%time_end
      asked%tolerance = options%tolerance
      asked%load_steps = options%load_steps
      asked%smallest_load_step = options%smallest_load_step
      asked%iterations = options%iterations
      asked%products = options%products
      asked%breaks = options%breaks
      asked%krylov = options%krylov
      asked%preconditioner = options%preconditioner
    end if
    call make_room(present(report), told, residuals)
    status = perion_simulation_solve(self%handle, asked, told)
    if (present(report)) call take(report, told, residuals, energies)
    call check(status, error)
  end procedure simulation_solve

  module procedure simulation_relax
    type(raw_relax) :: asked
    type(raw_report) :: told
    real(c_double), allocatable, target :: residuals(:), energies(:)
    integer(c_int32_t) :: status

    call perion_relax_options_init(asked, c_sizeof(asked))
    if (present(options)) then
      asked%tolerance = options%tolerance
      asked%energy_tolerance = options%energy_tolerance
      asked%steps = options%steps
      asked%ramp = options%ramp
      asked%breaks = options%breaks
    end if
    call make_room(present(report), told, residuals, energies)
    status = perion_simulation_relax(self%handle, asked, told)
    if (present(report)) call take(report, told, residuals, energies)
    call check(status, error)
  end procedure simulation_relax

  module procedure simulation_set_surface_areas
    character(*), parameter :: call = 'perion_simulation_set_surface_areas'
    real(c_double), allocatable, target :: copy(:)
    real(c_double), pointer, contiguous :: each(:)

    if (.not. is_live(self%handle, call, error)) return
    if (.not. lined_up(areas, copy, each, call, error)) return
    call check(perion_simulation_set_surface_areas(self%handle, c_text(set), &
        size(areas, kind=c_int64_t), each), error)
  end procedure simulation_set_surface_areas

  !> A report for the library to fill, with room for residuals and energies where they are wanted and can be had.
  subroutine make_room(wanted, told, residuals, energies)
    logical, intent(in) :: wanted
    type(raw_report), intent(inout) :: told
    real(c_double), allocatable, target, intent(inout) :: residuals(:)
    real(c_double), allocatable, target, intent(inout), optional :: energies(:)
    integer :: failed

    call perion_report_init(told, c_sizeof(told))
    told%steps = -1
    if (.not. wanted) return
    allocate (residuals(most_residuals), stat=failed)
    if (failed /= 0) return
    told%residuals_or_null = c_loc(residuals)
    told%residual_capacity = most_residuals
    if (.not. present(energies)) return
    allocate (energies(most_residuals), stat=failed)
    if (failed == 0) told%energies_or_null = c_loc(energies)
  end subroutine make_room

  !> A call that was refused has left the report as it was.
  subroutine take(report, told, residuals, energies)
    type(perion_report), intent(inout) :: report
    type(raw_report), intent(in) :: told
    real(c_double), allocatable, intent(in) :: residuals(:), energies(:)

    if (told%steps < 0) return
    report%steps = told%steps
    report%time = told%time
    report%cuts = told%cuts
    report%iterations = told%iterations
    report%evaluations = told%evaluations
    report%broken_bonds = told%broken_bonds
    report%share = told%share
    report%residual = told%residual
    report%elastic = told%elastic
    report%external_work = told%external_work
    call list(report%residuals, residuals)
    call list(report%energies, energies)

  contains

    !> The numbers that the library has written to a room, none without one.
    subroutine list(numbers, room)
      real(c_double), allocatable, intent(inout) :: numbers(:)
      real(c_double), allocatable, intent(in) :: room(:)
      integer(c_int64_t) :: count
      integer :: failed

      if (allocated(numbers)) deallocate (numbers)
      count = 0
      if (allocated(room)) count = min(told%residual_count, most_residuals)
      allocate (numbers(count), stat=failed)
      if (failed == 0 .and. count > 0) numbers(:) = room(:count)
    end subroutine list
  end subroutine take

end submodule statics_procedures
