!> Equilibria of a plate.
module statics_tests
  use, intrinsic :: iso_c_binding
  use perion
  use scenes, only: make_plate, rows
  use testing
  implicit none
  private
  public :: test_statics

  character(*), parameter :: file = 'statics'

  !> Stops a run after so many steps.
  type, extends(perion_progress) :: impatient
    integer(c_int64_t) :: heard = 0, patience = 5
  contains
    procedure :: report => impatient_report
  end type impatient

contains

  subroutine test_statics()
    call run(file, 'a plate under traction is solved and relaxed alike', both_ways)
    call run(file, 'a relaxation can be stopped', stopped)
    call run(file, 'bad options are refused', bad_options)
    call run(file, 'what nothing holds is told, with its residuals', no_equilibrium)
  end subroutine test_statics

  subroutine make_pulled(simulation)
    type(perion_simulation), intent(inout) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe('left', PERION_QUANTITY_DISPLACEMENT, 1, 0d0)
    call simulation%prescribe('left', PERION_QUANTITY_DISPLACEMENT, 2, 0d0)
    call simulation%prescribe('right', PERION_QUANTITY_TRACTION, 1, 1d-3)
  end subroutine make_pulled

  subroutine both_ways()
    type(perion_simulation) :: solved, relaxed
    type(perion_report) :: report
    type(perion_solve_options) :: solving
    type(perion_relax_options) :: relaxing
    real(c_double) :: areas(rows), force(2), reaction(2), one(2), other(2)

    call make_pulled(solved)
    call make_pulled(relaxed)
    solving%load_steps = 2
    solving%krylov = PERION_KRYLOV_MINIMAL_RESIDUALS
    solving%preconditioner = PERION_PRECONDITIONER_BLOCK_DIAGONAL
    call solved%solve(solving, report)
    call assert(report%steps == 2 .and. report%share >= 1, 'not two load steps')
    call assert(size(report%residuals) >= 2, 'no residuals')
    call assert(report%residual <= 1d-8, 'not converged')
    call solved%sum(PERION_FIELD_REACTION, reaction, 'left')
    call solved%sum(PERION_FIELD_BODY_FORCE, force)
    call assert(abs(reaction(1) + 1d-3 * rows) < 1d-8, 'another reaction')
    call assert(abs(force(1) - 1d-3 * rows) < 1d-12, 'another force')
    relaxing%tolerance = 1d-9
    call relaxed%relax(relaxing, report)
    call assert(report%iterations > 20 .and. report%elastic > 0, 'not relaxed')
    call assert(size(report%energies) == size(report%residuals), 'energies are missing')
    call assert(report%energies(size(report%energies)) <= 1d-9, 'not at rest')
    call solved%sum(PERION_FIELD_DISPLACEMENT, one, 'right')
    call relaxed%sum(PERION_FIELD_DISPLACEMENT, other, 'right')
    call assert(abs(other(1) / one(1) - 1) < 1d-6, 'they differ')
    areas = 2
    call solved%set_surface_areas('right', areas)
    call solved%evaluate()
    call solved%sum(PERION_FIELD_BODY_FORCE, force)
    call assert(abs(force(1) - 2d-3 * rows) < 1d-12, 'areas do not count')
    call solved%solve()
    call solved%destroy()
    call relaxed%destroy()
  end subroutine both_ways

  subroutine impatient_report(self, simulation, done, total, time, stop)
    class(impatient), intent(inout) :: self
    type(perion_simulation), intent(in) :: simulation
    integer(c_int64_t), intent(in) :: done, total
    real(c_double), intent(in) :: time
    logical, intent(inout) :: stop
    real(c_double) :: moved(2)

    call simulation%sum(PERION_FIELD_DISPLACEMENT, moved, 'right')
    call assert(all(abs(moved) <= 0) .and. abs(time) <= 0, 'the body has changed on the way')
    call assert(done <= total, 'more steps than there can be')
    self%heard = done
    stop = done == self%patience
  end subroutine impatient_report

  subroutine stopped()
    type(perion_simulation) :: simulation
    type(impatient), target :: watcher
    type(perion_report) :: report
    type(perion_error), allocatable :: error

    call make_pulled(simulation)
    call simulation%set_progress(watcher)
    call simulation%relax(report=report, error=error)
    call assert_fails(error, PERION_ERROR_INTERRUPTED, 'progress')
    call assert(watcher%heard == 5 .and. report%steps == 0, 'not stopped after five steps')
    call assert(size(report%residuals) == 5, 'not five residuals')
    call simulation%destroy()
  end subroutine stopped

  subroutine bad_options()
    type(perion_simulation) :: simulation
    type(perion_report) :: report
    type(perion_solve_options) :: solving
    type(perion_relax_options) :: relaxing
    type(perion_error), allocatable :: error

    call make_pulled(simulation)
    solving%tolerance = 2
    call simulation%solve(solving, report, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'tolerance' is 2")
    call assert(.not. allocated(report%residuals), 'a refused call has changed the report')
    relaxing%steps = -1
    call simulation%relax(relaxing, error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'steps' is -1")
    call simulation%set_surface_areas('right', [1d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'right')
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, 2, 1d0)
    call simulation%solve(error=error)
    call assert_fails(error, PERION_ERROR_STATE, 'velocity is prescribed')
    call simulation%destroy()
  end subroutine bad_options

  subroutine no_equilibrium()
    type(perion_simulation) :: simulation
    type(perion_report) :: report
    type(perion_error), allocatable :: error

    call make_pulled(simulation)
    call simulation%release('left', PERION_QUANTITY_DISPLACEMENT, 1)
    call simulation%solve(report=report, error=error)
    call assert_fails(error, PERION_ERROR_CONVERGENCE, 'residuals')
    call assert(report%steps == 0 .and. report%cuts > 3, 'it was solved')
    call assert(size(report%residuals) > 3, 'no residuals')
    call simulation%destroy()
  end subroutine no_equilibrium

end module statics_tests
