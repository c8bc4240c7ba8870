!> Bonds: listed, broken and weakened by the host.
module bond_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_bonds

  character(*), parameter :: file = 'bonds.f90'

contains

  subroutine test_bonds()
    call run(file, 'arrays that are absent are left out', absent_arrays)
    call run(file, 'every bond is listed once and no longer than the horizon', bonds_listed_once)
    call run(file, 'a stretched plate has stretched bonds', stretches)
    call run(file, 'pairs that are broken stay broken', broken_pairs)
    call run(file, 'a weakened bond keeps its integrity', weakened_bonds)
    call run(file, 'a crack across breaks all bonds across and no others', crack_across)
  end subroutine test_bonds

  subroutine absent_arrays()
    integer(c_int64_t) :: count, same_count
    real(c_double), allocatable :: stretch(:)
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_get_bonds(simulation, 0_c_int64_t, count=count))
    call assert_ok(perion_simulation_bond_count(simulation, same_count))
    call assert(count == same_count .and. count > 0, 'the counts differ')
    allocate (stretch(count))
    call assert_ok(perion_simulation_get_bonds(simulation, count, stretch_or_null=stretch, &
        count=same_count))
    call assert(all(abs(stretch) <= 0), 'the undeformed plate has stretched bonds')
    call assert_refused(perion_simulation_get_bonds(simulation, count - 1, &
        stretch_or_null=stretch, count=same_count), PERION_ERROR_ARGUMENT, "'capacity' is")
    call destroy(simulation)
  end subroutine absent_arrays

  subroutine all_bonds(simulation, pairs, stretch, integrity)
    type(c_ptr), intent(in) :: simulation
    integer(c_int64_t), allocatable, intent(out) :: pairs(:, :)
    real(c_double), allocatable, intent(out) :: stretch(:), integrity(:)
    integer(c_int64_t) :: count

    call assert_ok(perion_simulation_bond_count(simulation, count))
    allocate (pairs(2, count), stretch(count), integrity(count))
    call assert_ok(perion_simulation_get_bonds(simulation, count, pairs, stretch, integrity, count))
  end subroutine all_bonds

  subroutine bonds_listed_once()
    integer(c_int64_t), allocatable :: pairs(:, :)
    real(c_double), allocatable :: stretch(:), integrity(:)
    real(c_double) :: reference(2, 0:plate_count - 1)
    logical, allocatable :: seen(:, :)
    integer(c_int64_t) :: k, one, other, within
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_REFERENCE_POSITION, reference, &
        2 * plate_count))
    call all_bonds(simulation, pairs, stretch, integrity)
    allocate (seen(0:plate_count - 1, 0:plate_count - 1), source=.false.)
    do k = 1, size(pairs, 2, c_int64_t)
      one = minval(pairs(:, k))
      other = maxval(pairs(:, k))
      call assert(.not. seen(one, other), 'a bond is listed twice')
      seen(one, other) = .true.
    end do
    within = 0
    do one = 0, plate_count - 1
      do other = one + 1, plate_count - 1
        if (norm2(reference(:, other) - reference(:, one)) < 3.015_c_double) within = within + 1
      end do
    end do
    call assert(within == size(pairs, 2), 'the bonds are not the pairs within the horizon')
    call assert(all(same_bits(integrity, 1.0_c_double)), 'a bond is not intact from the start')
    call destroy(simulation)
  end subroutine bonds_listed_once

  subroutine stretches()
    integer(c_int64_t), allocatable :: pairs(:, :)
    real(c_double), allocatable :: stretch(:), integrity(:)
    real(c_double) :: reference(2, plate_count)
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_REFERENCE_POSITION, reference, &
        2 * plate_count))
    call assert_ok(perion_simulation_set(simulation, PERION_FIELD_POSITION, &
        1.25_c_double * reference, 2 * plate_count))
    call all_bonds(simulation, pairs, stretch, integrity)
    ! Displacements of up to 4 carry errors of up to 9e-16, on bonds of length 1 and more.
    call assert(all(close_to(stretch, 0.25_c_double, 4e-15_c_double)), 'a stretch is not 1/4')
    call destroy(simulation)
  end subroutine stretches

  subroutine broken_pairs()
    integer(c_int64_t) :: pairs(2, 3)
    real(c_double) :: damage(0:plate_count - 1)
    type(c_ptr) :: simulation

    ! Two bonds of the first point, and a pair too far apart for one.
    pairs = reshape([0_c_int64_t, 1_c_int64_t, int(columns, c_int64_t), 0_c_int64_t, &
        0_c_int64_t, plate_count - 1], [2, 3])
    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_break_bonds(simulation, 3_c_int64_t, pairs))
    call assert(broken_bonds(simulation) == 2, 'not two bonds are broken')
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_DAMAGE, damage, plate_count))
    call assert(damage(0) > damage(1) .and. damage(1) > 0, 'the damage is at other points')
    call assert(abs(damage(plate_count - 1)) <= 0, 'a pair without a bond is damaged')
    pairs(1, 1) = plate_count
    call assert_refused(perion_simulation_break_bonds(simulation, 3_c_int64_t, pairs), &
        PERION_ERROR_ARGUMENT, "'pairs'[0] names point 144")
    call destroy(simulation)
  end subroutine broken_pairs

  subroutine weakened_bonds()
    integer(c_int64_t), parameter :: pair(2) = [3, 4]
    integer(c_int64_t), allocatable :: pairs(:, :)
    real(c_double), allocatable :: stretch(:), integrity(:)
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_set_bond_integrity(simulation, 1_c_int64_t, pair, &
        [0.375_c_double]))
    call assert_refused(perion_simulation_set_bond_integrity(simulation, 1_c_int64_t, pair, &
        [1.5_c_double]), PERION_ERROR_ARGUMENT, 'between 0 and 1')
    call all_bonds(simulation, pairs, stretch, integrity)
    associate (is_it => minval(pairs, 1) == pair(1) .and. maxval(pairs, 1) == pair(2))
      call assert(count(is_it) == 1, 'the bond is not listed')
      call assert(all(same_bits(integrity, merge(0.375_c_double, 1.0_c_double, is_it))), &
          'the integrities are not 0.375 for one bond and 1 for the others')
    end associate
    call destroy(simulation)
  end subroutine weakened_bonds

  subroutine crack_across()
    real(c_double), parameter :: middle = columns / 2, height = rows
    integer(c_int64_t), allocatable :: pairs(:, :)
    real(c_double), allocatable :: stretch(:), integrity(:)
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call assert_ok(perion_simulation_break_crossing(simulation, 2_c_int64_t, &
        [middle, -1.0_c_double, middle, height + 1.0_c_double]))
    call all_bonds(simulation, pairs, stretch, integrity)
    call assert(all(across_middle(pairs) .eqv. integrity < 0.5_c_double), &
        'the crack does not break all bonds across, or breaks others')
    ! Neither half holds the other any longer: the right one stays at rest, to the last bit.
    call assert_ok(perion_simulation_prescribe(simulation, c('left'), PERION_QUANTITY_VELOCITY, 0, &
        -0.02_c_double))
    call make_steps(simulation, 40)
    call assert_right_half_at_rest(simulation)
    call destroy(simulation)
  end subroutine crack_across

  subroutine assert_right_half_at_rest(simulation)
    type(c_ptr), intent(in) :: simulation
    real(c_double) :: velocity(2, columns, rows)

    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, velocity, 2 * plate_count))
    call assert(all(abs(velocity(:, columns / 2 + 1:, :)) <= 0), 'the right half moves')
    call assert(any(abs(velocity(:, 2:columns / 2, :)) > 0), 'the left half does not move')
  end subroutine assert_right_half_at_rest

end module bond_tests
