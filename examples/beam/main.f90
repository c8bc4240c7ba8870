!> A beam is bent far: which formulations keep its points in line?
!>
!> After Ganzenmueller, Hiermaier and May 2015, section 5.3: E = 100 GPa, nu = 0.3, plane stress, the law of Saint Venant
!> and Kirchhoff; a beam of 8 x 1 mm is moved at its end by up to 8 mm. Where its supports are the text doesn't say. Here it
!> is half of a beam whose middle is moved across: the supports hold one point each at 8 mm from it, on the axis, which is
!> free to slide along and to turn.
!>
!> Points are out of line by their distance from the middle of their four neighbours, a root mean square over all
!> inside, in spacings. Affine motions have none of it, and a curvature k has k/4 (in 1 over spacings). Pairs of
!> points that move together, which a gradient averaged over a family does not see, have much.
!>
!> Each equilibrium is looked for by Newton's method, and from where that finds none by relaxation.
!>
!> Usage: beam [deflection in mm, 8] [points across, odd, 9] [steps, 10] [law, saint_venant_kirchhoff]
!>             [curves, beam_fortran.csv] [output files, beam_fortran]
!>
!> In order: points and sets, then for each formulation: model, simulation, conditions, equilibria, files. Units
!> are mm, N and MPa. The same program stands beside this one in C and in Rust; all three print the same hash.
module beam_host
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  implicit none
  private
  public :: bend, force_on, hash_values, make_lattice, mean_across, out_of_line, timoshenko, write_curves

  real(real64), parameter, public :: span = 16, height = 1   ! mm
  real(real64), parameter, public :: modulus = 1d5           ! MPa
  real(real64), parameter, public :: poissons_ratio = 0.3d0
  real(real64), parameter, public :: small = 0.01d0          ! mm, for the stiffness

contains

  !> The points: a block that has points at the supports and in the middle.
  subroutine make_lattice(points, spacing)
    type(perion_points), intent(inout) :: points
    real(real64), intent(in) :: spacing
    real(real64) :: half, end, up

    half = 0.5d0 * spacing
    end = 0.5d0 * span + 0.5d0 * spacing
    up = 0.5d0 * height
    call points%create_block([-end, -up], [end, up], spacing)
    call points%add_set_box('middle', [-half, -up], [half, up])
    call points%add_set_box('axis', [-half, -half], [half, half])
    call points%add_set_box('start', [-end, -up], [spacing - end, up])
    call points%add_set_box('end', [end - spacing, -up], [end, up])
    call points%add_set_box('left', [-end, -half], [spacing - end, half])
    call points%add_set_box('right', [end - spacing, -half], [end, half])
  end subroutine make_lattice

  !> The mean displacement of a set across the beam.
  function mean_across(points, body, set) result(mean)
    type(perion_points), intent(in) :: points
    type(perion_simulation), intent(in) :: body
    character(*), intent(in) :: set
    real(real64) :: mean, moved(2)
    integer :: length

    call points%set_size(set, length)
    call body%sum(PERION_FIELD_DISPLACEMENT, moved, set)
    mean = moved(2) / length
  end function mean_across

  !> What holds the middle.
  function force_on(body) result(force)
    type(perion_simulation), intent(in) :: body
    real(real64) :: force, reaction(2)

    call body%sum(PERION_FIELD_REACTION, reaction, 'middle')
    force = reaction(2)
  end function force_on

  !> Force over deflection of a beam that bends and shears, its shear factor that of a rectangle.
  pure function timoshenko() result(stiffness)
    real(real64) :: stiffness, inertia, shear_factor, shear_modulus

    inertia = height * height * height / 12
    shear_factor = 10 * (1 + poissons_ratio) / (12 + 11 * poissons_ratio)
    shear_modulus = 0.5d0 * modulus / (1 + poissons_ratio)
    stiffness = 1 / (span * span * span / (48 * modulus * inertia) &
        + span / (4 * shear_factor * shear_modulus * height))
  end function timoshenko

  !> Moves the middle, by Newton's method or, where that has ended before, by relaxation.
  subroutine bend(points, body, deflection, solved_to)
    type(perion_points), intent(in) :: points
    type(perion_simulation), intent(inout) :: body
    real(real64), intent(in) :: deflection
    real(real64), intent(inout) :: solved_to
    type(perion_solve_options) :: options
    type(perion_error), allocatable :: error
    real(real64) :: before

    before = mean_across(points, body, 'middle')
    call body%prescribe('middle', PERION_QUANTITY_DISPLACEMENT, 2, deflection)
    if (abs(solved_to - before) <= 0) then
      options%tolerance = 1d-6
      options%smallest_load_step = 0.25d0
      options%products = 500
      call body%solve(options, error=error)
      solved_to = mean_across(points, body, 'middle')
      if (.not. allocated(error)) return
      if (error%status /= PERION_ERROR_CONVERGENCE) then
        write (error_unit, '(a)') error%message
        stop 1, quiet=.true.
      end if
    end if
    call body%relax()
  end subroutine bend

  !> How far points inside are from the middle of their four neighbours, a root mean square.
  pure function out_of_line(along, across, moved) result(apart)
    integer, intent(in) :: along, across
    real(real64), intent(in) :: moved(2, along, across)
    real(real64) :: apart, squares, away
    integer :: row, column, axis

    squares = 0
    do row = 2, across - 1
      do column = 2, along - 1
        do axis = 1, 2
          away = moved(axis, column, row) &
              - 0.25d0 * (moved(axis, column - 1, row) + moved(axis, column + 1, row) &
              + moved(axis, column, row - 1) + moved(axis, column, row + 1))
          squares = squares + away * away
        end do
      end do
    end do
    apart = sqrt(squares / ((across - 2) * (along - 2)))
  end function out_of_line

  !> A row for each deflection; the first line names the formulations.
  subroutine write_curves(path, forms, deflections, apart)
    character(*), intent(in) :: path, forms(:)
    real(real64), intent(in) :: deflections(:), apart(:, :)
    integer :: unit, form, k

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(*(a))') 'deflection (mm)', (',' // trim(forms(form)), form=1, size(forms))
    do k = 1, size(deflections)
      write (unit, '(f8.4, 4(",", f10.5))') deflections(k), apart(k, :)
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

end module beam_host

program beam
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use beam_host
  implicit none

  ! What is compared, and the influence functions.
  character(26), parameter :: forms(4) = [character(26) :: 'correspondence', 'correspondence_silling', &
      'correspondence_wan', 'bond_associated_quadrature']
  character(12), parameter :: influences(4) = [character(12) :: 'constant', 'constant', 'constant', &
      'cubic_spline']

  type(perion_points) :: points
  type(perion_model) :: steel
  type(perion_simulation) :: body
  character(500) :: argument, law, curves, files
  character(9) :: ending
  integer :: across, steps, late, count, flaw, form, k
  integer(int64) :: hash
  real(real64) :: deflection, spacing, bent
  real(real64) :: stiffness(size(forms)), solved_to(size(forms)), force(size(forms))
  real(real64), allocatable :: deflections(:), apart(:, :), moved(:, :)

  deflection = 8
  across = 9
  steps = 10
  law = 'saint_venant_kirchhoff'
  curves = 'beam_fortran.csv'
  files = 'beam_fortran'
  flaw = 0
  call get_command_argument(1, argument)
  if (command_argument_count() > 0) read (argument, *, iostat=flaw) deflection
  call get_command_argument(2, argument)
  if (flaw == 0 .and. command_argument_count() > 1) read (argument, *, iostat=flaw) across
  call get_command_argument(3, argument)
  if (flaw == 0 .and. command_argument_count() > 2) read (argument, *, iostat=flaw) steps
  if (command_argument_count() > 3) call get_command_argument(4, law)
  if (command_argument_count() > 4) call get_command_argument(5, curves)
  if (command_argument_count() > 5) call get_command_argument(6, files)
  if (flaw /= 0 .or. .not. deflection > 0 .or. across < 5 .or. modulo(across, 2) /= 1 &
      .or. steps < 2 .or. steps > 99) then
    write (error_unit, '(a)') 'a deflection above 0, an odd number of points across from 5 on ' // &
        'and 2 to 99 steps are needed'
    stop 1, quiet=.true.
  end if
  late = 4 * steps / 5   ! files are written here, and at the end

  spacing = height / across
  call make_lattice(points, spacing)
  call points%count(count)
  allocate (moved(2, count), apart(steps, size(forms)))
  deflections = [(deflection * k / steps, k=1, steps)]
  print '(i0, a, f0.3, a, i0, a)', count, ' points, ', deflection, ' mm in ', steps, ' steps'

  hash = 0
  solved_to = 0
  do form = 1, size(forms)
    call steel%create(trim(forms(form)))
    call steel%choose('plane', 'stress')
    call steel%choose('material', trim(law))
    call steel%choose('influence', trim(influences(form)))
    call steel%set('youngs_modulus', modulus)
    call steel%set('poissons_ratio', poissons_ratio)
    call steel%set('density', 7.85d-9)   ! t/mm3
    call steel%set('horizon', 3.015d0 * spacing)
    call body%create(points, steel)
    call steel%destroy()
    call body%prescribe('left', PERION_QUANTITY_DISPLACEMENT, 2, 0d0)
    call body%prescribe('right', PERION_QUANTITY_DISPLACEMENT, 2, 0d0)
    call body%prescribe('axis', PERION_QUANTITY_DISPLACEMENT, 1, 0d0)

    call bend(points, body, small, solved_to(form))
    bent = mean_across(points, body, 'middle') &
        - 0.5d0 * (mean_across(points, body, 'start') + mean_across(points, body, 'end'))
    stiffness(form) = force_on(body) / bent / timoshenko()
    do k = 1, steps
      call bend(points, body, deflections(k), solved_to(form))
      call body%get(PERION_FIELD_DISPLACEMENT, moved)
      apart(k, form) = out_of_line(count / across, across, moved) / spacing
      if (files /= '' .and. (k == late .or. k == steps)) then
        write (ending, '(a, i2.2, a)') '_', k, '.vtu'
        call body%write_vtk(trim(files) // '_' // trim(forms(form)) // trim(ending), &
            [PERION_FIELD_DISPLACEMENT, PERION_FIELD_STRAIN])
      end if
    end do
    force(form) = force_on(body)
    call hash_values(hash, size(moved), moved)
    call body%destroy()
  end do
  call points%destroy()

  ! Results.
  print '(a)', 'formulation                 stiffness  solved to    force  out of line  at the end'
  do form = 1, size(forms)
    print '(a, f11.4, f11.3, i9, f13.4, f12.4)', forms(form), stiffness(form), solved_to(form), &
        nint(force(form)), apart(late, form), apart(steps, form)
  end do
  print '(a, f10.3)', 'out of line at  ', deflections(late)
  print '(a, z10.10)', 'hash            ', hash
  if (curves /= '') call write_curves(curves, forms, deflections, apart)
end program beam
