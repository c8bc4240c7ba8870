!> The bodies that the tests work on, in units in which spacing, density and Young's modulus are 1:
!> then waves run about one spacing in a unit of time.
module scenes
  use, intrinsic :: iso_c_binding
  use perion
  use testing, only: same_bits
  implicit none
  private
  public :: across_middle, broken_bonds, columns, make_model, make_plate, make_points, make_steps
  public :: pattern, plate_count, pull, rows, same, state, take_state

  integer, parameter :: columns = 16, rows = 9
  integer, parameter :: plate_count = columns * rows
  real(c_double), parameter :: critical_stretch = 0.02_c_double

  !> What a simulation of the plate is, as far as calls can tell.
  type :: state
    real(c_double), dimension(2, plate_count) :: displacement = 0, velocity = 0
    real(c_double) :: time = 0
    integer :: steps = 0
    real(c_double), allocatable :: integrity(:)
  end type state

contains

  !> A plate of columns x rows points, x fastest, its corner in the origin; its first and last
  !> column are the sets 'left' and 'right'. A `factor` gives it that many times the columns and
  !> rows.
  subroutine make_points(points, factor)
    type(perion_points), intent(inout) :: points
    integer, optional, intent(in) :: factor
    real(c_double) :: width, height

    width = columns
    height = rows
    if (present(factor)) then
      width = factor * width
      height = factor * height
    end if
    call points%create_block([0d0, 0d0], [width, height], 1d0)
    call points%add_set_box('left', [0d0, 0d0], [1d0, height])
    call points%add_set_box('right', [width - 1, 0d0], [width, height])
  end subroutine make_points

  !> A material whose bonds break at a stretch of 0.02 when it is `brittle`.
  subroutine make_model(model, brittle)
    type(perion_model), intent(inout) :: model
    logical, intent(in) :: brittle

    call model%create('bond_based')
    call model%set('density', 1d0)
    call model%set('youngs_modulus', 1d0)
    call model%set('horizon', 3.015d0)
    if (brittle) call model%set('critical_stretch', critical_stretch)
  end subroutine make_model

  subroutine make_plate(simulation, brittle, factor)
    type(perion_simulation), intent(inout) :: simulation
    logical, intent(in) :: brittle
    integer, optional, intent(in) :: factor
    type(perion_points) :: points
    type(perion_model) :: model

    call make_points(points, factor)
    call make_model(model, brittle)
    call simulation%create(points, model)
    call points%destroy()
    call model%destroy()
  end subroutine make_plate

  !> Pulls the left and right edge of a plate apart, fast enough to tear a brittle one in 40 steps.
  subroutine pull(simulation)
    type(perion_simulation), intent(inout) :: simulation

    call simulation%prescribe('left', PERION_QUANTITY_VELOCITY, 1, -0.02d0)
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, 1, 0.02d0)
  end subroutine pull

  !> Steps as long as is known to be stable.
  subroutine make_steps(simulation, steps)
    type(perion_simulation), intent(inout) :: simulation
    integer, intent(in) :: steps
    real(c_double) :: time_step

    call simulation%stable_time_step(time_step)
    call simulation%step(time_step, steps)
  end subroutine make_steps

  function broken_bonds(simulation)
    type(perion_simulation), intent(in) :: simulation
    integer(c_int64_t) :: broken_bonds
    type(perion_health) :: health

    call simulation%health(health)
    broken_bonds = health%broken_bonds
  end function broken_bonds

  !> Which of these pairs of points have one in the left and one in the right half.
  function across_middle(pairs)
    integer, intent(in) :: pairs(:, :)
    logical :: across_middle(size(pairs, 2)), left(2)
    integer :: k

    do k = 1, size(pairs, 2)
      left = mod(pairs(:, k) - 1, columns) < columns / 2
      across_middle(k) = left(1) .neqv. left(2)
    end do
  end function across_middle

  !> Numbers without a pattern that an error could hide in.
  function pattern(components, count) result(values)
    integer, intent(in) :: components, count
    real(c_double) :: values(components, count)
    integer :: point, component

    do point = 1, count
      do component = 1, components
        values(component, point) = 1e-3_c_double * sin(real(7 * point + 3 * component, c_double))
      end do
    end do
  end function pattern

  subroutine take_state(simulation, now)
    type(perion_simulation), intent(in) :: simulation
    type(state), intent(out) :: now
    integer :: count

    call simulation%get(PERION_FIELD_DISPLACEMENT, now%displacement)
    call simulation%get(PERION_FIELD_VELOCITY, now%velocity)
    call simulation%time(now%time)
    call simulation%step_count(now%steps)
    call simulation%bond_count(count)
    allocate (now%integrity(count))
    call simulation%get_bonds(integrity=now%integrity)
  end subroutine take_state

  function same(one, other)
    type(state), intent(in) :: one, other
    logical :: same

    same = all(same_bits(one%displacement, other%displacement)) &
        .and. all(same_bits(one%velocity, other%velocity)) &
        .and. same_bits(one%time, other%time) .and. one%steps == other%steps
    if (same) same = all(same_bits(one%integrity, other%integrity))
  end function same

end module scenes
