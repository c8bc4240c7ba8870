!> A bar under a tension: by how much each formulation errs in its length, for horizons of 2 to 7 spacings.
!>
!> After Partmann et al. 2026, section 5.1: a bar of 100 x 10 x 10 mm, E = 210 GPa, nu = 1/4, bears 200 kN.
!> Points near a surface lack bonds, and so bond_based and ordinary_state_based make a bar too soft or too
!> stiff; the bond-associated quadrature does not. Bonds and the linear solid are compared with F L/(E A), the
!> laws of Saint Venant and Kirchhoff with the stretch l of l (l^2 - 1) = 2 F/(E A).
!>
!> The load is a body force on the last layer, and a horizon of layers outside the length is clamped, as in the
!> paper; or it is a traction on both ends of a bar of twice the length, which is held along its axis in the
!> middle alone, so that the solution is exact. Its length is then that from the middle to the last layer.
!>
!> Usage: traction_bar [points across, 5] [smallest horizon in spacings, 2] [largest, 3] [formulation, all]
!>                     [load: body_force or traction, body_force] [curves, traction_bar_fortran.csv]
!>
!> In order, for each formulation and horizon: points and sets, model, simulation, conditions, equilibrium,
!> results. Units are m, s and kg. The same program stands beside this one in C and in Rust; all three print
!> the same hash.
module traction_bar_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  implicit none
  private
  public :: solve, write_curves

  real(real64), parameter :: length = 0.1d0, width = 0.01d0      ! m
  real(real64), parameter :: modulus = 210d9, force = 2d5        ! Pa, N

  !> A formulation, its influence function, and whether it is compared with linear elasticity.
  type, public :: form
    character(26) :: formulation
    character(12) :: influence
    logical :: is_linear
  end type form

contains

  !> The points: a block, its axis the x axis. What is loaded and what is held are named.
  subroutine make_bar(points, across, ratio, is_traction)
    type(perion_points), intent(inout) :: points
    integer, intent(in) :: across, ratio
    logical, intent(in) :: is_traction
    real(real64) :: h, end, lower(3), upper(3), middle(3)

    h = width / across
    if (is_traction) then
      end = length + 0.5d0 * h
      lower = [-end, 0d0, 0d0]
      upper = [end, width, width]
      middle = [-0.5d0 * h, 0d0, 0d0]
      call points%create_block(lower, upper, h)
      call points%add_set_box('start', lower, [h - end, width, width])
      call points%add_set_box('end', [end - h, 0d0, 0d0], upper)
      call points%add_set_box('held', middle, [0.5d0 * h, width, width])
      call points%add_set_box('pin', middle, [0.5d0 * h, h, h])
      call points%add_set_box('guide', [-0.5d0 * h, width - h, 0d0], [0.5d0 * h, width, h])
    else
      lower = [-ratio * h, 0d0, 0d0]
      upper = [length, width, width]
      call points%create_block(lower, upper, h)
      call points%add_set_box('held', lower, [0d0, width, width])
      call points%add_set_box('end', [length - h, 0d0, 0d0], upper)
    end if
  end subroutine make_bar

  !> The conditions.
  subroutine load(bar, across, is_traction)
    type(perion_simulation), intent(inout) :: bar
    integer, intent(in) :: across
    logical, intent(in) :: is_traction
    real(real64) :: stress, depth

    stress = force / (width * width)
    depth = width / across
    call bar%prescribe('held', PERION_QUANTITY_DISPLACEMENT, 1, 0d0)
    if (is_traction) then
      call bar%prescribe('start', PERION_QUANTITY_TRACTION, 1, -stress)
      call bar%prescribe('end', PERION_QUANTITY_TRACTION, 1, stress)
      ! Against rigid motion.
      call bar%prescribe('pin', PERION_QUANTITY_DISPLACEMENT, 2, 0d0)
      call bar%prescribe('pin', PERION_QUANTITY_DISPLACEMENT, 3, 0d0)
      call bar%prescribe('guide', PERION_QUANTITY_DISPLACEMENT, 3, 0d0)
    else
      call bar%prescribe('held', PERION_QUANTITY_DISPLACEMENT, 2, 0d0)
      call bar%prescribe('held', PERION_QUANTITY_DISPLACEMENT, 3, 0d0)
      call bar%prescribe('end', PERION_QUANTITY_BODY_FORCE, 1, stress / depth)
    end if
  end subroutine load

  !> The length change of a bar in tension, exactly.
  pure function exact(is_linear) result(change)
    logical, intent(in) :: is_linear
    real(real64) :: change, strain, stretch
    integer :: k

    strain = force / (width * width) / modulus
    if (is_linear) then
      change = length * strain
      return
    end if
    stretch = 1
    do k = 1, 20
      stretch = stretch - (stretch * (stretch * stretch - 1) - 2 * strain) / (3 * stretch * stretch - 1)
    end do
    change = length * (stretch - 1)
  end function exact

  !> Solves one bar: its error in percent.
  subroutine solve(one, across, ratio, is_traction, hash, error)
    type(form), intent(in) :: one
    integer, intent(in) :: across, ratio
    logical, intent(in) :: is_traction
    integer(int64), intent(inout) :: hash
    real(real64), intent(out) :: error
    type(perion_points) :: points
    type(perion_model) :: steel
    type(perion_simulation) :: bar
    type(perion_report) :: report
    integer :: count, layer
    real(real64) :: moved(3)
    real(real64), allocatable :: displacement(:, :)

    call make_bar(points, across, ratio, is_traction)
    call points%count(count)
    call points%set_size('end', layer)

    call steel%create(trim(one%formulation))
    call steel%set('youngs_modulus', modulus)
    call steel%set('poissons_ratio', 0.25d0)
    call steel%set('density', 7850d0)   ! kg/m3
    call steel%set('horizon', 1.005d0 * ratio * (width / across))
    if (one%influence /= '') call steel%choose('influence', trim(one%influence))
    call bar%create(points, steel)
    call load(bar, across, is_traction)

    ! Equilibrium, by Newton's method.
    call bar%solve(report=report)

    call bar%sum(PERION_FIELD_DISPLACEMENT, moved, 'end')
    error = 100 * (moved(1) / layer / exact(one%is_linear) - 1)
    print '(i7, i10, 2x, a, f12.4, i10)', ratio, count, one%formulation, error, report%evaluations
    allocate (displacement(3, count))
    call bar%get(PERION_FIELD_DISPLACEMENT, displacement)
    call hash_values(hash, size(displacement), displacement)
    call bar%destroy()
    call steel%destroy()
    call points%destroy()
  end subroutine solve

  !> A row for each horizon, a column for each formulation; the first line names them.
  subroutine write_curves(path, forms, first, errors)
    character(*), intent(in) :: path
    type(form), intent(in) :: forms(:)
    integer, intent(in) :: first
    real(real64), intent(in) :: errors(:, first:)
    integer :: unit, k, ratio

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(*(a))') 'horizon (spacings)', &
        (',' // trim(forms(k)%formulation) // ' (%)', k=1, size(forms))
    do ratio = first, ubound(errors, 2)
      write (unit, '(i2, ",", *(f11.4, :, ","))') ratio, errors(:, ratio)
    end do
    close (unit)
  end subroutine write_curves

  !> Goes on with a fingerprint of the bits of numbers.
  subroutine hash_values(hash, length, values)
    integer(int64), intent(inout) :: hash
    integer, intent(in) :: length
    real(real64), intent(in) :: values(length)
    integer(int64), parameter :: factor = 65599, modulus = 1099511627689_int64
    integer(int64), parameter :: lower_half = int(z'ffffffff', int64)
    integer(int64) :: bits
    integer :: k

    do k = 1, length
      bits = transfer(values(k), bits)
      hash = mod(hash * factor + iand(bits, lower_half), modulus)
      hash = mod(hash * factor + shiftr(bits, 32), modulus)
    end do
  end subroutine hash_values

end module traction_bar_host

program traction_bar
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use traction_bar_host
  implicit none

  type(form), parameter :: forms(4) = [ &
      form('bond_based', '', .true.), &
      form('ordinary_state_based', 'inverse', .true.), &
      form('correspondence', 'inverse', .false.), &
      form('bond_associated_quadrature', 'cubic_spline', .false.)]

  character(500) :: argument, formulation, load_name, curves
  type(form), allocatable :: chosen(:)
  integer :: numbers(3), flaw, k, ratio
  integer(int64) :: hash
  logical :: is_traction
  real(real64), allocatable :: errors(:, :)

  ! Points across, and the smallest and the largest horizon in spacings.
  numbers = [5, 2, 3]
  flaw = 0
  do k = 1, min(3, command_argument_count())
    call get_command_argument(k, argument)
    if (flaw == 0) read (argument, *, iostat=flaw) numbers(k)
  end do
  formulation = 'all'
  load_name = 'body_force'
  curves = 'traction_bar_fortran.csv'
  if (command_argument_count() > 3) call get_command_argument(4, formulation)
  if (command_argument_count() > 4) call get_command_argument(5, load_name)
  if (command_argument_count() > 5) call get_command_argument(6, curves)
  is_traction = load_name == 'traction'
  chosen = pack(forms, formulation == 'all' .or. forms%formulation == formulation)
  if (flaw /= 0 .or. numbers(1) < 2 .or. numbers(2) < 1 .or. numbers(3) < numbers(2) &
      .or. numbers(3) > 16 .or. size(chosen) == 0) then
    write (error_unit, '(a)') 'at least 2 points across, horizons from 1 to 16 spacings and one of', &
        '  ' // forms%formulation
    stop 1, quiet=.true.
  end if

  print '(i0, a)', numbers(1), ' points, that is so many across, under ' &
      // trim(merge('a traction                    ', 'a body force on the last layer', is_traction))
  print '(a)', 'horizon    points  formulation                    error %    forces'
  hash = 0
  allocate (errors(size(chosen), numbers(2):numbers(3)))
  do ratio = numbers(2), numbers(3)
    do k = 1, size(chosen)
      call solve(chosen(k), numbers(1), ratio, is_traction, hash, errors(k, ratio))
    end do
  end do
  print '(a, z10.10)', 'hash            ', hash
  if (curves /= '') call write_curves(curves, chosen, numbers(2), errors)
end program traction_bar
