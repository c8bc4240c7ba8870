!> Bonds: listed, broken and weakened by the host.
module bonds_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_bonds

  character(*), parameter :: file = 't450_bonds'

contains

  subroutine test_bonds()
    call run(file, 'every bond is listed once and no longer than the horizon', bonds_listed_once)
    call run(file, 'arrays may be left out or longer, not too short', lists_of_some)
    call run(file, 'a stretched plate has stretched bonds', stretches)
    call run(file, 'pairs that are broken stay broken', broken_pairs)
    call run(file, 'a weakened bond keeps its integrity', weakened_bonds)
    call run(file, 'a crack across breaks all bonds across and no others', crack_across)
    call run(file, 'nonsense is refused and changes nothing', nonsense_is_refused)
  end subroutine test_bonds

  subroutine bonds_listed_once()
    integer, allocatable :: pairs(:, :)
    integer(int64), allocatable :: wide(:, :)
    real(c_double), allocatable :: stretch(:), integrity(:)
    real(c_double) :: reference(2, plate_count)
    logical, allocatable :: seen(:, :)
    integer :: count, k, one, other, within
    integer(int64) :: wide_count
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%get(PERION_FIELD_REFERENCE_POSITION, reference)
    call simulation%bond_count(count)
    call simulation%bond_count(wide_count)
    call assert(count == wide_count, 'the counts differ')
    allocate (pairs(2, count), wide(2, count), stretch(count), integrity(count))
    call simulation%get_bonds(pairs, stretch, integrity)
    call simulation%get_bonds(wide)
    call assert(all(pairs == wide), 'the pairs of 32 and 64 bits differ')
    call assert(minval(pairs) == 1 .and. maxval(pairs) == plate_count, 'points do not count from 1')
    allocate (seen(plate_count, plate_count), source=.false.)
    do k = 1, count
      one = minval(pairs(:, k))
      other = maxval(pairs(:, k))
      call assert(.not. seen(one, other), 'a bond is listed twice')
      seen(one, other) = .true.
    end do
    within = 0
    do one = 1, plate_count
      do other = one + 1, plate_count
        if (norm2(reference(:, other) - reference(:, one)) >= 3.015d0) cycle
        within = within + 1
        call assert(seen(one, other), 'a pair within the horizon has no bond')
      end do
    end do
    call assert(within == count, 'there are bonds beyond the horizon')
    call assert(all(abs(stretch) <= 0), 'the undeformed plate has stretched bonds')
    call assert(all(same_bits(integrity, 1d0)), 'a bond is not intact from the start')
    call simulation%destroy()
  end subroutine bonds_listed_once

  subroutine lists_of_some()
    real(c_double), allocatable :: stretch(:), integrity(:), table(:, :)
    integer, allocatable :: pairs(:, :)
    integer(int64), allocatable :: backwards(:, :)
    integer :: count
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.false.)
    call simulation%bond_count(count)
    allocate (stretch(count + 1), integrity(count + 1), pairs(2, count + 1), table(2, count), &
        backwards(3, count))
    stretch = -7
    integrity = -7
    pairs = -7
    call simulation%get_bonds(stretch=stretch)
    call simulation%get_bonds(integrity=integrity)
    call simulation%get_bonds(pairs)
    call assert(all(abs(stretch(:count)) <= 0), 'the stretch is not listed')
    call assert(all(same_bits(integrity(:count), 1d0)), 'the integrity is not listed')
    call assert(all(pairs(:, :count) > 0), 'the pairs are not listed')
    call assert(same_bits(stretch(count + 1), -7d0) .and. same_bits(integrity(count + 1), -7d0) &
        .and. all(pairs(:, count + 1) == -7), 'what lies beyond the bonds was touched')
    call simulation%get_bonds(stretch=table(2, :), integrity=table(1, :))
    call assert(all(same_bits(table(1, :), 1d0)) .and. all(abs(table(2, :)) <= 0), &
        'sections of an array are not filled')
    backwards(2:1:-1, :) = pairs(:, :count)
    backwards(3, :) = -7
    call simulation%get_bonds(backwards(2:1:-1, count:1:-1))
    call assert(all(backwards(2:1:-1, count:1:-1) == pairs(:, :count)), 'a section of pairs is not filled')

    stretch = -7
    call simulation%get_bonds(stretch=stretch(2:count), error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'perion_simulation_get_bonds: the arrays have room')
    call simulation%get_bonds(pairs(:, :count), stretch, error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'different lengths')
    call simulation%get_bonds(pairs(:1, :), error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'it must be (2,count)')
    call assert(all(same_bits(stretch, -7d0)), 'a refused call has written its output')
    call simulation%destroy()
  end subroutine lists_of_some

  subroutine stretches()
    real(c_double), allocatable :: stretch(:)
    real(c_double) :: reference(2, plate_count)
    integer :: count
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%get(PERION_FIELD_REFERENCE_POSITION, reference)
    call simulation%set(PERION_FIELD_POSITION, 1.25d0 * reference)
    call simulation%bond_count(count)
    allocate (stretch(count))
    call simulation%get_bonds(stretch=stretch)
    ! Displacements of up to 4 carry errors of up to 9e-16, on bonds of length 1 and more.
    call assert(all(close_to(stretch, 0.25d0, 4d-15)), 'a stretch is not 1/4')
    call simulation%destroy()
  end subroutine stretches

  subroutine broken_pairs()
    ! Two bonds of the first point, and a pair too far apart for one.
    integer, parameter :: pairs(2, 3) = reshape([1, 2, columns + 1, 1, 1, plate_count], [2, 3])
    integer, parameter :: list(3, 3) = reshape([5, 0, 6, 7, 0, 8, 6, 0, 5], [3, 3])
    real(c_double), parameter :: integrities(3) = [0d0, 0.5d0, 0d0]
    real(c_double) :: damage(plate_count)
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%break_bonds(pairs)
    call assert(broken_bonds(simulation) == 2, 'not two bonds are broken')
    call simulation%get(PERION_FIELD_DAMAGE, damage)
    call assert(damage(1) > damage(2) .and. damage(2) > 0, 'the damage is at other points')
    call assert(abs(damage(plate_count)) <= 0, 'a pair without a bond is damaged')
    call simulation%break_bonds(reshape([3_int64, 4_int64, 3_int64, 4_int64], [2, 2]))
    call assert(broken_bonds(simulation) == 3, 'not one more bond is broken')
    ! Sections of a host's lists: the pair of points 5 and 6 alone.
    call simulation%break_bonds(list(3:1:-2, ::2))
    call simulation%set_bond_integrity(list(3:1:-2, ::2), integrities(::2))
    call assert(broken_bonds(simulation) == 4, 'the bond of a section is not broken, or others are')
    call simulation%destroy()
  end subroutine broken_pairs

  subroutine weakened_bonds()
    integer, parameter :: pair(2, 1) = reshape([4, 5], [2, 1])
    integer, allocatable :: pairs(:, :)
    real(c_double), allocatable :: integrity(:)
    logical, allocatable :: is_it(:)
    integer :: bonds
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%set_bond_integrity(pair, [0.5d0])
    call simulation%set_bond_integrity(int(pair, int64), [0.375d0])
    call simulation%bond_count(bonds)
    allocate (pairs(2, bonds), integrity(bonds), is_it(bonds))
    call simulation%get_bonds(pairs, integrity=integrity)
    is_it(:) = minval(pairs, 1) == 4 .and. maxval(pairs, 1) == 5
    call assert(count(is_it) == 1, 'the bond is not listed')
    call assert(all(same_bits(integrity, merge(0.375d0, 1d0, is_it))), &
        'the integrities are not 0.375 for one bond and 1 for the others')
    call simulation%destroy()
  end subroutine weakened_bonds

  subroutine crack_across()
    real(c_double), parameter :: middle = columns / 2, height = rows
    integer, allocatable :: pairs(:, :)
    real(c_double), allocatable :: integrity(:)
    real(c_double) :: velocity(2, columns, rows)
    integer :: count
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.true.)
    call simulation%break_crossing(reshape([middle, -1d0, middle, height + 1d0], [2, 2]))
    call simulation%bond_count(count)
    allocate (pairs(2, count), integrity(count))
    call simulation%get_bonds(pairs, integrity=integrity)
    call assert(all(across_middle(pairs) .eqv. integrity < 0.5d0), &
        'the crack does not break all bonds across, or breaks others')
    ! Neither half holds the other any longer: the right one stays at rest, to the last bit.
    call simulation%prescribe('left', PERION_QUANTITY_VELOCITY, 1, -0.02d0)
    call make_steps(simulation, 40)
    call get_plate(velocity)
    call assert(all(abs(velocity(:, columns / 2 + 1:, :)) <= 0), 'the right half moves')
    call assert(any(abs(velocity(:, 2:columns / 2, :)) > 0), 'the left half does not move')
    call simulation%destroy()
  contains
    !> A host that keeps its plate by column and row hands it on as a list of points.
    subroutine get_plate(values)
      real(c_double), intent(inout) :: values(2, plate_count)

      call simulation%get(PERION_FIELD_VELOCITY, values)
    end subroutine get_plate
  end subroutine crack_across

  subroutine nonsense_is_refused()
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    type(state) :: before, after

    call make_plate(simulation, brittle=.true.)
    call take_state(simulation, before)
    call simulation%break_bonds(reshape([1, 145], [2, 1]), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'pairs' names point 145; points are 1 to 144")
    call simulation%break_bonds(reshape([1, 2, 0, 1], [2, 2]), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'pairs' names point 0")
    call simulation%break_bonds(reshape([2, 2], [2, 1]), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "'pairs'[0] pairs point 1 with itself (points and axes in this text count from 0)")
    call simulation%break_bonds(reshape([1, 2, 3], [3, 1]), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'pairs' has the shape (3,1); it must be (2,count)")
    call simulation%set_bond_integrity(reshape([1, 2], [2, 1]), [1.5d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'between 0 and 1')
    call simulation%set_bond_integrity(reshape([1, 2], [2, 1]), [0.5d0, 0.5d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "there are 2 values for 1 of 'pairs'")
    call simulation%set_bond_integrity(reshape([1, 200], [2, 1]), [0.5d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'pairs' names point 200")
    call simulation%break_crossing(reshape([0d0, 0d0, 0d0, 1d0, 1d0, 1d0], [3, 2]), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "'vertices' has the shape (3,2); it must be (2,vertex_count)")
    call simulation%break_crossing(reshape([1d0, 1d0], [2, 1]), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'perion_simulation_break_crossing')
    call simulation%break_crossing(reshape([1d0, 1d0, 2d0, nan()], [2, 2]), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'vertex 1, axis 1, is NaN')
    call assert_fails(error, PERION_ERROR_ARGUMENT, '(points and axes in this text count from 0)')
    call take_state(simulation, after)
    call assert(same(before, after), 'a refused call has changed the simulation')
    call simulation%destroy()
  end subroutine nonsense_is_refused

end module bonds_tests
