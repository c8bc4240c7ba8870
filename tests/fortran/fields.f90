!> Fields: whole, by set, between a host's own numbers, and summed.
module field_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_fields

  character(*), parameter :: file = 'fields.f90'

contains

  subroutine test_fields()
    call run(file, 'what is set comes back with the same bits', set_comes_back)
    call run(file, 'a host array of six numbers a point takes and gives a field', strided_fields)
    call run(file, 'a set is read and written in its own order', fields_of_sets)
    call run(file, 'sums are those of the points', sums)
    call run(file, 'every field can be asked for after a step', every_field)
    call run(file, 'nonsense is refused and changes nothing', nonsense_is_refused)
  end subroutine test_fields

  !> Numbers without a pattern that an error could hide in.
  function pattern(components, count) result(values)
    integer, intent(in) :: components
    integer(c_int64_t), intent(in) :: count
    real(c_double) :: values(components, count)
    integer(c_int64_t) :: point
    integer :: component

    do point = 1, count
      do component = 1, components
        values(component, point) = 1e-3_c_double * sin(real(7 * point + 3 * component, c_double))
      end do
    end do
  end function pattern

  subroutine set_comes_back()
    real(c_double), dimension(2, plate_count) :: given, back, reference
    type(c_ptr) :: simulation
    integer :: k
    integer(c_int32_t), parameter :: fields(*) = [PERION_FIELD_DISPLACEMENT, &
        PERION_FIELD_VELOCITY, PERION_FIELD_BODY_FORCE]

    given = pattern(2, plate_count)
    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    do k = 1, size(fields)
      call assert_ok(perion_simulation_set(simulation, fields(k), given, 2 * plate_count))
      call assert_ok(perion_simulation_get(simulation, fields(k), back, 2 * plate_count))
      call assert(all(same_bits(back, given)), 'a field has come back another')
    end do
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_REFERENCE_POSITION, reference, &
        2 * plate_count))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_POSITION, back, 2 * plate_count))
    call assert(all(same_bits(back, reference + given)), 'position is not reference + displacement')
    call destroy(simulation)
  end subroutine set_comes_back

  subroutine strided_fields()
    real(c_double), parameter :: untouched = -77
    real(c_double) :: host(6, plate_count), velocity(2, plate_count)
    type(c_ptr) :: simulation

    host = untouched
    host(4:5, :) = pattern(2, plate_count)
    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    ! From row 4 on, every six numbers.
    call assert_ok(perion_simulation_set_strided(simulation, field=PERION_FIELD_VELOCITY, &
        values=host(4, 1), count=plate_count, stride=6_c_int64_t))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, velocity, 2 * plate_count))
    call assert(all(same_bits(velocity, host(4:5, :))), 'the velocity is not that of rows 4 and 5')
    call assert_ok(perion_simulation_get_strided(simulation, field=PERION_FIELD_VELOCITY, &
        values=host(1, 1), count=plate_count, stride=6_c_int64_t))
    call assert(all(same_bits(host(1:2, :), velocity)), 'rows 1 and 2 are not the velocity')
    call assert(all(same_bits(host([3, 6], :), untouched)), 'what lies between was touched')
    call destroy(simulation)
  end subroutine strided_fields

  subroutine fields_of_sets()
    real(c_double) :: at_right(3, rows), all_points(2, columns, rows)
    integer(c_int64_t), parameter :: count = rows
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    at_right = 0
    at_right(1:2, :) = pattern(2, count)
    call assert_ok(perion_simulation_set_strided(simulation, c('right'), &
        PERION_FIELD_DISPLACEMENT, at_right, count, 3_c_int64_t))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, all_points, &
        2 * plate_count))
    call assert(all(same_bits(all_points(:, columns, :), at_right(1:2, :))), &
        'the right edge is not where it was put')
    call assert(all(abs(all_points(:, :columns - 1, :)) <= 0), 'other points have moved')
    call destroy(simulation)
  end subroutine fields_of_sets

  subroutine sums()
    real(c_double) :: volume(1), reaction(2), at_left(2), at_right(2), force(2)
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call assert_ok(perion_simulation_sum(simulation, PERION_FIELD_VOLUME, components=volume))
    call assert(same_bits(volume(1), real(plate_count, c_double)), 'the volumes are not 1 each')
    call assert_ok(perion_simulation_sum(simulation, PERION_FIELD_INTERNAL_FORCE, components=force))
    ! Forces of up to 0.1 on 144 points cancel but for their rounding.
    call assert(all(close_to(force, 0.0_c_double, 1e-14_c_double)), 'forces in pairs do not cancel')
    call assert_ok(perion_simulation_sum(simulation, PERION_FIELD_REACTION, c('left'), at_left))
    call assert_ok(perion_simulation_sum(simulation, PERION_FIELD_REACTION, c('right'), at_right))
    call assert_ok(perion_simulation_sum(simulation, PERION_FIELD_REACTION, components=reaction))
    call assert(all(close_to(reaction, at_left + at_right, 1e-14_c_double)), &
        'there are reactions at points that are not held')
    call assert(at_left(1) < 0 .and. at_right(1) > 0, 'the grips do not pull')
    call destroy(simulation)
  end subroutine sums

  subroutine every_field()
    integer(c_int32_t), parameter :: vectors(*) = [PERION_FIELD_REFERENCE_POSITION, &
        PERION_FIELD_POSITION, PERION_FIELD_DISPLACEMENT, PERION_FIELD_VELOCITY, &
        PERION_FIELD_ACCELERATION, PERION_FIELD_INTERNAL_FORCE, PERION_FIELD_BODY_FORCE, &
        PERION_FIELD_REACTION]
    integer(c_int32_t), parameter :: scalars(*) = [PERION_FIELD_VOLUME, PERION_FIELD_DENSITY, &
        PERION_FIELD_DAMAGE, PERION_FIELD_STRAIN_ENERGY_DENSITY, &
        PERION_FIELD_DISSIPATED_ENERGY_DENSITY, PERION_FIELD_NEIGHBOR_COUNT, &
        PERION_FIELD_TIME_STEP_ESTIMATE]
    real(c_double) :: vector(2, plate_count), scalar(plate_count)
    type(c_ptr) :: simulation
    integer :: k

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    do k = 1, size(vectors)
      vector = huge(vector)
      call assert_ok(perion_simulation_get(simulation, vectors(k), vector, 2 * plate_count))
      call assert(all(abs(vector) < 100), 'a vector is too large, or was not filled')
    end do
    do k = 1, size(scalars)
      scalar = huge(scalar)
      call assert_ok(perion_simulation_get(simulation, scalars(k), scalar, plate_count))
      call assert(all(scalar >= 0 .and. scalar < 100), 'a scalar is too large, or was not filled')
      if (scalars(k) == PERION_FIELD_DAMAGE) then
        call assert(any(scalar > 0) .and. all(scalar <= 1), 'damage lies between 0 and 1')
      end if
    end do
    call destroy(simulation)
  end subroutine every_field

  subroutine nonsense_is_refused()
    real(c_double) :: values(2, plate_count), back(2, plate_count)
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_refused(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, values, plate_count), &
        PERION_ERROR_ARGUMENT, "'length' is 144")
    call assert_refused(perion_simulation_get(simulation, 99, values, plate_count), &
        PERION_ERROR_ARGUMENT, "'field' is 99")
    values = 0.001_c_double
    call assert_refused(perion_simulation_set(simulation, PERION_FIELD_REACTION, values, &
        2 * plate_count), PERION_ERROR_UNSUPPORTED, 'reaction cannot be set')
    values(1, 7) = transfer(int(z'7ff8000000000000', c_int64_t), 0.0_c_double)
    call assert_refused(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, values, &
        2 * plate_count), PERION_ERROR_ARGUMENT, 'NaN')
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, back, 2 * plate_count))
    call assert(all(abs(back) <= 0), 'a refused velocity was taken in part')
    call assert_refused(perion_simulation_get_strided(simulation, c('left'), &
        PERION_FIELD_VELOCITY, back, int(rows, c_int64_t), 1_c_int64_t), PERION_ERROR_ARGUMENT, &
        "'stride' is 1")
    call destroy(simulation)
  end subroutine nonsense_is_refused

end module field_tests
