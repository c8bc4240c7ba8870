!> A square of points without order is let go after a stretch: do they move as one?
!>
!> After Ganzenmueller, Hiermaier and May 2015, section 5.2.1: 444 points, each with its own horizon, the distance
!> of its twelfth neighbour; plane stress, E = 1, nu = 0.3, density 1. Both edges are stretched by 10 %, and the
!> square swings. A gradient averaged over a family says little about each bond of it, and so plain
!> correspondence falls into disorder in the first contraction. With a penalty, or at quadrature points on
!> bonds, the points keep their order.
!>
!> Disorder is measured by what is left of bonds when the gradient of their family has been taken out:
!> the root mean square of |eta - F xi| over that of the lengths of bonds.
!>
!> Usage: patch [points, examples/patch/points.txt] [records, 388; 30 make a contraction]
!>              [curves, patch_fortran.csv] [output files, patch_fortran]
!>
!> In order: points with horizons, then for each formulation: model, simulation, a state set by hand, step,
!> fields, a file. Numbers have no units. The same program stands beside this one in C and in Rust; all three print
!> the same hash.
module patch_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  public :: disorder_of, find_nearest, hash_values, size_of, write_curves

contains

  !> The nearest of each point, and its horizon, the distance of the last of them.
  subroutine find_nearest(places, nearest, horizons)
    real(real64), intent(in) :: places(:, :)
    integer, intent(out) :: nearest(:, :)
    real(real64), intent(out) :: horizons(:)
    real(real64) :: last, squares(size(places, 2))
    integer :: i, k

    do i = 1, size(places, 2)
      squares = (places(1, :) - places(1, i))**2 + (places(2, :) - places(2, i))**2
      last = 0
      do k = 1, size(nearest, 1)
        nearest(k, i) = minloc(squares, 1, squares > last)
        last = squares(nearest(k, i))
      end do
      horizons(i) = sqrt(last)
    end do
  end subroutine find_nearest

  !> What is left of bonds without the gradients of their families, over their length.
  pure function disorder_of(places, nearest, now, gradients) result(disorder)
    real(real64), intent(in) :: places(:, :), now(:, :), gradients(:, :, :)
    integer, intent(in) :: nearest(:, :)
    real(real64) :: disorder, left, lengths, bond(2), rest(2)
    integer :: i, k

    left = 0
    lengths = 0
    do i = 1, size(places, 2)
      do k = 1, size(nearest, 1)
        bond = places(:, nearest(k, i)) - places(:, i)
        rest = now(:, nearest(k, i)) - now(:, i)
        rest = rest - gradients(:, 1, i) * bond(1) - gradients(:, 2, i) * bond(2)
        left = left + (rest(1) * rest(1) + rest(2) * rest(2))
        lengths = lengths + (bond(1) * bond(1) + bond(2) * bond(2))
      end do
    end do
    disorder = sqrt(left / lengths)
  end function disorder_of

  !> Mean square distance from the middle of the square, which stays where it is.
  pure function size_of(now) result(squares)
    real(real64), intent(in) :: now(:, :)
    real(real64) :: squares, middle(2)
    integer :: i

    middle = 0
    do i = 1, size(now, 2)
      middle = middle + now(:, i) / size(now, 2)
    end do
    squares = 0
    do i = 1, size(now, 2)
      squares = squares + sum((now(:, i) - middle)**2)
    end do
    squares = squares / size(now, 2)
  end function size_of

  !> A row for each record; the first line names the formulations.
  subroutine write_curves(path, forms, interval, disorder)
    character(*), intent(in) :: path, forms(:)
    real(real64), intent(in) :: interval, disorder(:, :)
    integer :: unit, form, record

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(*(a))') 'time', (',' // trim(forms(form)), form=1, size(forms))
    do record = 1, size(disorder, 1)
      write (unit, '(f9.5, 3(",", f9.5))') interval * record, disorder(record, :)
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

end module patch_host

program patch
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use patch_host
  implicit none

  real(real64), parameter :: modulus = 1, poissons_ratio = 0.3d0, density = 1, stretch = 0.1d0
  integer, parameter :: nearest_count = 12, steps = 10, most_contractions = 12
  character(26), parameter :: forms(3) = [character(26) :: &
      'correspondence', 'correspondence_wan', 'bond_associated_quadrature']

  type(perion_points) :: points
  type(perion_model) :: plate
  type(perion_simulation) :: body
  type(perion_energy) :: energy
  character(500) :: cloud, argument, curves, files
  integer :: records, count, flaw, form, record, found(size(forms))
  integer(int64) :: hash
  integer, allocatable :: nearest(:, :)
  real(real64) :: time_step, given, before, last, now_size, drift(size(forms))
  real(real64) :: contractions(most_contractions, size(forms))
  real(real64), allocatable :: places(:, :), areas(:), horizons(:), now(:, :), disorder(:, :)
  real(real64), allocatable :: gradients(:, :, :)

  cloud = 'examples/patch/points.txt'
  records = 388
  curves = 'patch_fortran.csv'
  files = 'patch_fortran'
  flaw = 0
  if (command_argument_count() > 0) call get_command_argument(1, cloud)
  call get_command_argument(2, argument)
  if (command_argument_count() > 1) read (argument, *, iostat=flaw) records
  if (command_argument_count() > 2) call get_command_argument(3, curves)
  if (command_argument_count() > 3) call get_command_argument(4, files)
  if (flaw /= 0 .or. records < 1) then
    write (error_unit, '(a)') 'at least one record is needed'
    stop 1, quiet=.true.
  end if

  ! The points, with their areas, and the horizon of each.
  call points%read(trim(cloud))
  call points%count(count)
  allocate (places(2, count), now(2, count), gradients(2, 2, count))
  allocate (areas(count), horizons(count), nearest(nearest_count, count))
  allocate (disorder(records, size(forms)))
  call points%get_coordinates(places)
  call points%get_volumes(areas)
  call find_nearest(places, nearest, horizons)
  call points%set_horizons(horizons)

  ! A fifth of the time that a wave takes through the smallest area; speed of a wave in a plate.
  time_step = 0.2d0 * sqrt(minval(areas)) &
      / sqrt(modulus / (1 - poissons_ratio * poissons_ratio) / density)
  print '(i0, a, i0, a, f8.6)', count, ' points, ', records * steps, ' steps of ', time_step

  hash = 0
  drift = 0
  found = 0
  contractions = 0
  do form = 1, size(forms)
    call plate%create(trim(forms(form)))
    call plate%choose('plane', 'stress')
    call plate%set('youngs_modulus', modulus)
    call plate%set('poissons_ratio', poissons_ratio)
    call plate%set('density', density)
    call body%create(points, plate)
    call plate%destroy()

    ! Stretched, and let go.
    call body%set(PERION_FIELD_DISPLACEMENT, stretch * places)
    call body%energy(energy)
    given = energy%elastic

    before = huge(before)
    last = huge(last)
    do record = 1, records
      call body%step(time_step, steps)
      call body%get(PERION_FIELD_POSITION, now)
      call body%get(PERION_FIELD_DEFORMATION_GRADIENT, gradients)
      call body%energy(energy)
      disorder(record, form) = disorder_of(places, nearest, now, gradients)
      drift(form) = max(drift(form), abs((energy%kinetic + energy%elastic) / given - 1))

      ! A contraction is where the square is smallest.
      now_size = size_of(now)
      if (last < before .and. last < now_size .and. found(form) < most_contractions) then
        if (found(form) == 0 .and. files /= '') call body%write_vtk( &
            trim(files) // '_' // trim(forms(form)) // '.vtu', &
            [PERION_FIELD_DISPLACEMENT, PERION_FIELD_VON_MISES_STRESS])
        found(form) = found(form) + 1
        contractions(found(form), form) = disorder(record - 1, form)
      end if
      before = last
      last = now_size
    end do
    call body%get(PERION_FIELD_DISPLACEMENT, now)
    call hash_values(hash, size(now), now)
    call body%destroy()
  end do
  call points%destroy()

  ! Results.
  print '(a)', 'formulation                 contractions  disorder at the first   largest  energy drift'
  do form = 1, size(forms)
    print '(a, i14, f23.4, f10.4, f14.6)', forms(form), found(form), contractions(1, form), &
        maxval(contractions(:, form)), drift(form)
  end do
  print '(a, f10.5)', 'time            ', time_step * steps * records
  print '(a, z10.10)', 'hash            ', hash
  if (curves /= '') call write_curves(curves, forms, time_step * steps, disorder)
end program patch
