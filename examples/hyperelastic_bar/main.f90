!> A bar of a hyperelastic material is drawn out: the total and the updated Lagrangian form against the exact answer.
!>
!> After Bergel and Li 2016, example II: a bar of 0.1 x 0.1 x 1 with lambda = 200 and mu = 20 of Saint Venant
!> and Kirchhoff, held along its axis at the bottom, under a traction at the top. A stretch of 1 + s needs
!> the traction E s (1 + s)(1 + s/2): the displacement of 0.01 that the paper compares with belongs to 0.590575. The
!> traction of 14 that it names belongs to 0.1857.
!>
!> The weak forms are solved: the strong ones leave no surface free of traction. The layer that is held lies
!> outside the length, so that it and the last layer are a length apart.
!>
!> Usage: hyperelastic_bar [traction, 0.590575] [points across, 5] [loads on the way, 4]
!>                         [curves, hyperelastic_bar_fortran.csv] [output files, hyperelastic_bar_fortran]
!>
!> In order: points and sets, then for each formulation: model, simulation, conditions, equilibria, a file.
!> Numbers have no units. The same program stands beside this one in C and in Rust; all three print the same
!> hash.
module hyperelastic_bar_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  implicit none
  private
  public :: exact, hash_values, make_column, write_curves

  real(real64), parameter, public :: lambda = 200, mu = 20, density = 1.4d0
  real(real64), parameter, public :: width = 0.1d0, length = 1

contains

  !> The points: a block, its axis the z axis.
  subroutine make_column(points, across)
    type(perion_points), intent(inout) :: points
    integer, intent(in) :: across
    real(real64) :: h, lower(3), upper(3)

    h = width / across
    lower = [0d0, 0d0, -h]
    upper = [width, width, length]
    call points%create_block(lower, upper, h)
    call points%add_set_box('bottom', lower, [width, width, 0d0])
    call points%add_set_box('top', [0d0, 0d0, length - h], upper)
    call points%add_set_box('pin', lower, [h, h, 0d0])
    call points%add_set_box('guide', [width - h, 0d0, -h], [width, h, 0d0])
  end subroutine make_column

  !> The displacement of the top, exactly.
  pure function exact(modulus, traction) result(top)
    real(real64), intent(in) :: modulus, traction
    real(real64) :: top, s
    integer :: k

    s = 0
    do k = 1, 50
      s = s - (modulus * s * (1 + s) * (1 + 0.5d0 * s) - traction) &
          / (modulus * (1 + 3 * s + 1.5d0 * s * s))
    end do
    top = length * s
  end function exact

  !> A row for each load; the first line names the columns.
  subroutine write_curves(path, tractions, tops, answers)
    character(*), intent(in) :: path
    real(real64), intent(in) :: tractions(0:), tops(:, 0:), answers(0:)
    integer :: unit, k

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') 'traction,total Lagrangian,updated Lagrangian,exact'
    do k = 0, ubound(answers, 1)
      write (unit, '(f10.6, 3(",", f11.7))') tractions(k), tops(1, k), tops(2, k), answers(k)
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

end module hyperelastic_bar_host

program hyperelastic_bar
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use hyperelastic_bar_host
  implicit none

  character(18), parameter :: forms(2) = [character(18) :: 'total_lagrangian', 'updated_lagrangian']

  type(perion_points) :: points
  type(perion_model) :: rubber
  type(perion_simulation) :: bar
  type(perion_solve_options) :: options
  type(perion_report) :: report
  character(500) :: argument, curves, files
  integer :: across, loads, count, layer, flaw, form, k
  integer(int64) :: hash, forces
  real(real64) :: traction, modulus, moved(3)
  real(real64), allocatable :: tractions(:), answers(:), tops(:, :), displacement(:, :)

  traction = 0.590575d0
  across = 5
  loads = 4
  curves = 'hyperelastic_bar_fortran.csv'
  files = 'hyperelastic_bar_fortran'
  flaw = 0
  call get_command_argument(1, argument)
  if (command_argument_count() > 0) read (argument, *, iostat=flaw) traction
  call get_command_argument(2, argument)
  if (flaw == 0 .and. command_argument_count() > 1) read (argument, *, iostat=flaw) across
  call get_command_argument(3, argument)
  if (flaw == 0 .and. command_argument_count() > 2) read (argument, *, iostat=flaw) loads
  if (command_argument_count() > 3) call get_command_argument(4, curves)
  if (command_argument_count() > 4) call get_command_argument(5, files)
  if (flaw /= 0 .or. .not. traction > 0 .or. across < 3 .or. loads < 1 .or. loads > 100) then
    write (error_unit, '(a)') &
        'a traction above 0, at least 3 points across and 1 to 100 loads are needed'
    stop 1, quiet=.true.
  end if
  modulus = mu * (3 * lambda + 2 * mu) / (lambda + mu)

  call make_column(points, across)
  call points%count(count)
  call points%set_size('top', layer)
  print '(i0, a, f9.6)', count, ' points, a traction of ', traction
  tractions = [(traction * k / loads, k=0, loads)]
  answers = [(exact(modulus, traction * k / loads), k=0, loads)]
  allocate (tops(size(forms), 0:loads), source=0d0)
  allocate (displacement(3, count))

  hash = 0
  do form = 1, size(forms)
    call rubber%create(trim(forms(form)))
    call rubber%set('youngs_modulus', modulus)
    call rubber%set('poissons_ratio', lambda / (2 * (lambda + mu)))
    call rubber%set('density', density)
    call rubber%set('horizon', 2.015d0 * (width / across))
    call bar%create(points, rubber)
    call rubber%destroy()

    ! The bottom is free to narrow; single points keep the bar from moving as a whole.
    call bar%prescribe('bottom', PERION_QUANTITY_DISPLACEMENT, 3, 0d0)
    call bar%prescribe('pin', PERION_QUANTITY_DISPLACEMENT, 1, 0d0)
    call bar%prescribe('pin', PERION_QUANTITY_DISPLACEMENT, 2, 0d0)
    call bar%prescribe('guide', PERION_QUANTITY_DISPLACEMENT, 2, 0d0)

    ! Equilibria under growing loads.
    forces = 0
    options%tolerance = 1d-6
    do k = 1, loads
      call bar%prescribe('top', PERION_QUANTITY_TRACTION, 3, traction * k / loads)
      call bar%solve(options, report)
      forces = forces + report%evaluations
      call bar%sum(PERION_FIELD_DISPLACEMENT, moved, 'top')
      tops(form, k) = moved(3) / layer
    end do
    print '(a18, f12.6, f11.4, a, i7, a)', forms(form), tops(form, loads), &
        100 * (tops(form, loads) / exact(modulus, traction) - 1), ' %', forces, ' forces'
    call bar%get(PERION_FIELD_DISPLACEMENT, displacement)
    call hash_values(hash, size(displacement), displacement)
    if (files /= '') call bar%write_vtk(trim(files) // '_' // trim(forms(form)) // '.vtu', &
        [PERION_FIELD_DISPLACEMENT, PERION_FIELD_CAUCHY_STRESS])
    call bar%destroy()
  end do
  call points%destroy()

  print '(a, f10.6)', 'exact               ', exact(modulus, traction)
  print '(a, f10.6)', '  linear            ', length * traction / modulus
  print '(a, f10.6)', 'Young''s modulus     ', modulus
  print '(a, z10.10)', 'hash            ', hash
  if (curves /= '') call write_curves(curves, tractions, tops, answers)
end program hyperelastic_bar
