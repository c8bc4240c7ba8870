!> Fields: whole, by set, in sections of a host's own arrays, and summed.
module fields_tests
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_fields

  character(*), parameter :: file = 't600_fields'

  integer(c_int32_t), parameter :: vectors(*) = [PERION_FIELD_REFERENCE_POSITION, &
      PERION_FIELD_POSITION, PERION_FIELD_DISPLACEMENT, PERION_FIELD_VELOCITY, &
      PERION_FIELD_ACCELERATION, PERION_FIELD_INTERNAL_FORCE, PERION_FIELD_BODY_FORCE, &
      PERION_FIELD_REACTION]
  integer(c_int32_t), parameter :: scalars(*) = [PERION_FIELD_VOLUME, PERION_FIELD_DENSITY, &
      PERION_FIELD_DAMAGE, PERION_FIELD_STRAIN_ENERGY_DENSITY, &
      PERION_FIELD_STABILIZATION_ENERGY_DENSITY, &
      PERION_FIELD_DISSIPATED_ENERGY_DENSITY, PERION_FIELD_NEIGHBOR_COUNT, &
      PERION_FIELD_TIME_STEP_ESTIMATE, PERION_FIELD_VON_MISES_STRESS, PERION_FIELD_STRESS_33, &
      PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN, &
      PERION_FIELD_DILATATION]
  integer(c_int32_t), parameter :: tensors(*) = [PERION_FIELD_DEFORMATION_GRADIENT, &
      PERION_FIELD_STRAIN, PERION_FIELD_PLASTIC_STRAIN, PERION_FIELD_FIRST_PIOLA_STRESS, &
      PERION_FIELD_CAUCHY_STRESS, &
      PERION_FIELD_SHAPE_TENSOR, PERION_FIELD_MIXED_SHAPE_TENSOR, &
      PERION_FIELD_DEFORMED_SHAPE_TENSOR]

contains

  subroutine test_fields()
    call run(file, 'what is set comes back with the same bits', set_comes_back)
    call run(file, 'sections of a host''s array take and give a field', sections)
    call run(file, 'operators differentiate fields of the host', operators)
    call run(file, 'a set is read and written in its own order', fields_of_sets)
    call run(file, 'sums are those of the points', sums)
    call run(file, 'tensors have row and column as on paper', tensors_of_a_shear)
    call run(file, 'every field can be asked for after a step', every_field)
    call run(file, 'no field takes the shape of another', shapes)
    call run(file, 'nonsense is refused and changes nothing', nonsense_is_refused)
  end subroutine test_fields

  subroutine set_comes_back()
    real(c_double), dimension(2, plate_count) :: given, back, reference
    integer(c_int32_t), parameter :: fields(*) = [PERION_FIELD_DISPLACEMENT, &
        PERION_FIELD_VELOCITY, PERION_FIELD_BODY_FORCE]
    type(perion_simulation) :: simulation
    integer :: k

    given = pattern(2, plate_count)
    call make_plate(simulation, brittle=.false.)
    do k = 1, size(fields)
      call simulation%set(fields(k), given)
      call simulation%get(fields(k), back)
      call assert(all(same_bits(back, given)), 'a field has come back another')
    end do
    call simulation%get(PERION_FIELD_REFERENCE_POSITION, reference)
    call simulation%get(PERION_FIELD_POSITION, back)
    call assert(all(same_bits(back, reference + given)), 'position is not reference + displacement')
    call simulation%destroy()
  end subroutine set_comes_back

  subroutine sections()
    real(c_double), parameter :: untouched = -77
    real(c_double) :: host(6, plate_count), wide(5, 2 * plate_count), given(2, plate_count)
    type(perion_simulation) :: simulation

    given = pattern(2, plate_count)
    call make_plate(simulation, brittle=.false.)
    host = untouched
    host(4:5, :) = given
    call simulation%set(PERION_FIELD_VELOCITY, host(4:5, :))
    call simulation%get(PERION_FIELD_VELOCITY, host(1:2, :))
    call assert(all(same_bits(host(1:2, :), given)), 'rows 1 and 2 are not the velocity')
    call assert(all(same_bits(host([3, 6], :), untouched)), 'what lies between was touched')

    ! Neither neighbours nor in order: copies.
    wide = untouched
    wide(1:4:3, ::2) = given
    call simulation%set(PERION_FIELD_DISPLACEMENT, wide(1:4:3, ::2))
    call simulation%get(PERION_FIELD_DISPLACEMENT, wide(2:5:3, 2::2))
    call assert(all(same_bits(wide(2:5:3, 2::2), given)), 'the displacement is not in the section')
    call assert(all(same_bits(wide(3, :), untouched)) .and. all(same_bits(wide(2, ::2), untouched)), &
        'what lies between the section was touched')
    call simulation%get(PERION_FIELD_DISPLACEMENT, host(1:2, plate_count:1:-1))
    call assert(all(same_bits(host(1:2, plate_count:1:-1), given)), 'the backward section differs')
    call simulation%set(PERION_FIELD_DISPLACEMENT, host(2:1:-1, :))
    call simulation%get(PERION_FIELD_DISPLACEMENT, host(4:5, :))
    call assert(all(same_bits(host(4:5, :), host(2:1:-1, :))), 'the swapped rows differ')

    ! One number a point: a row of a host's array, in either direction.
    host = untouched
    call simulation%get(PERION_FIELD_VOLUME, host(6, :))
    call simulation%get(PERION_FIELD_DENSITY, host(2, plate_count:1:-1))
    call assert(all(same_bits(host(6, :), 1d0)) .and. all(same_bits(host(2, :), 1d0)), &
        'volume and density are not 1')
    call assert(all(same_bits(host([1, 3, 4, 5], :), untouched)), 'other rows were touched')
    call simulation%destroy()
  end subroutine sections

  subroutine fields_of_sets()
    real(c_double) :: at_right(3, rows), all_points(2, plate_count), volumes(rows)
    type(perion_simulation) :: simulation
    integer :: row

    call make_plate(simulation, brittle=.false.)
    at_right(1:2, :) = pattern(2, rows)
    call simulation%set(PERION_FIELD_DISPLACEMENT, at_right(1:2, :), set='right')
    call simulation%get(PERION_FIELD_DISPLACEMENT, all_points)
    do row = 1, rows
      call assert(all(same_bits(all_points(:, row * columns), at_right(1:2, row))), &
          'the right edge is not where it was put')
      all_points(:, row * columns) = 0
    end do
    call assert(all(abs(all_points) <= 0), 'other points have moved')
    call simulation%get(PERION_FIELD_VOLUME, volumes, set='left   ')
    call assert(all(same_bits(volumes, 1d0)), 'the volumes at the left are not 1')
    call simulation%destroy()
  end subroutine fields_of_sets

  subroutine sums()
    real(c_double) :: volume, one_volume(1), reaction(2), at_left(2), at_right(2), force(2), table(2, 2)
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call simulation%sum(PERION_FIELD_VOLUME, volume)
    call simulation%sum(PERION_FIELD_VOLUME, one_volume, set='right')
    call assert(same_bits(volume, real(plate_count, c_double)), 'the volumes are not 1 each')
    call assert(same_bits(one_volume(1), real(rows, c_double)), 'the volumes at the right are not 1 each')
    call simulation%sum(PERION_FIELD_INTERNAL_FORCE, force)
    ! Forces of up to 0.1 on 144 points cancel but for their rounding.
    call assert(all(close_to(force, 0d0, 1d-14)), 'forces in pairs do not cancel')
    call simulation%sum(PERION_FIELD_REACTION, at_left, 'left')
    call simulation%sum(PERION_FIELD_REACTION, at_right, 'right')
    call simulation%sum(PERION_FIELD_REACTION, reaction)
    call simulation%sum(PERION_FIELD_REACTION, table(2, :), 'left')
    call assert(all(same_bits(table(2, :), at_left)), 'a section is not filled')
    call assert(all(close_to(reaction, at_left + at_right, 1d-14)), &
        'there are reactions at points that are not held')
    call assert(at_left(1) < 0 .and. at_right(1) > 0, 'the grips do not pull')
    call simulation%destroy()
  end subroutine sums

  !> A shear of x by y: row 1, column 2 of F.
  subroutine tensors_of_a_shear()
    real(c_double) :: place(2, plate_count), gradient(2, 2, plate_count), expected(2, 2), sum(2, 2)
    real(c_double) :: host(3, 4, 2 * rows)
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    integer :: point

    call make_plate(simulation, brittle=.false.)
    call simulation%get(PERION_FIELD_REFERENCE_POSITION, place)
    place(1, :) = 0.0625d0 * place(2, :)
    place(2, :) = 0
    call simulation%set(PERION_FIELD_DISPLACEMENT, place)
    expected = reshape([1d0, 0d0, 0.0625d0, 1d0], [2, 2])
    call simulation%get(PERION_FIELD_DEFORMATION_GRADIENT, gradient)
    do point = 1, plate_count
      call assert(all(abs(gradient(:, :, point) - expected) < 1d-13), 'F is not that of the shear')
    end do
    host = -77
    call simulation%get(PERION_FIELD_DEFORMATION_GRADIENT, host(3:1:-2, 2:3, ::2), set='right')
    call assert(all(abs(host(3, 3, ::2) - 0.0625d0) < 1d-13) .and. all(abs(host(1, 2, ::2)) < 1d-13), &
        'F is not in the section')
    call assert(all(same_bits(host(2, :, :), -77d0)) .and. all(same_bits(host(:, :, 2::2), -77d0)), &
        'what lies between was touched')
    call simulation%sum(PERION_FIELD_DEFORMATION_GRADIENT, sum, set='right')
    call assert(all(abs(sum - rows * expected) < 1d-11), 'the sum is not that of the points')
    call simulation%get(PERION_FIELD_STRAIN, gradient(:, :, 2:), error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "'values' has the shape (2,2,143); field 16 needs (2,2,144)")
    call simulation%get(PERION_FIELD_STRAIN, gradient(:, :1, :rows), 'right', error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (2,1,9); field 16 needs (2,2,count)')
    call simulation%sum(PERION_FIELD_STRAIN, sum(:, :1), error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'adds up to 4')
    call simulation%destroy()
  end subroutine tensors_of_a_shear

  !> Row and column as on paper: row 1 of the gradient of (x + 2 y, 3 y) is (1, 2).
  subroutine operators()
    real(c_double) :: place(2, plate_count), field(2, plate_count), gradient(2, 2, plate_count)
    real(c_double) :: tensor(3, 2, plate_count), rows_of(3, plate_count), slope(2, plate_count)
    real(c_double) :: scalar(plate_count)
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    integer :: point

    call make_plate(simulation, brittle=.false.)
    call simulation%get(PERION_FIELD_REFERENCE_POSITION, place)
    field(1, :) = place(1, :) + 2 * place(2, :)
    field(2, :) = 3 * place(2, :)
    call simulation%gradient(PERION_OPERATOR_REFERENCE_UNDEFORMED, field, gradient)
    do point = 1, plate_count
      call assert(all(abs(gradient(:, :, point) - reshape([1d0, 0d0, 2d0, 3d0], [2, 2])) < 1d-11), &
          'the gradient has not its rows and columns')
    end do
    call simulation%gradient(PERION_OPERATOR_CURRENT_DEFORMED, field(1, :), slope)
    call assert(all(abs(slope(1, :) - 1) < 1d-11) .and. all(abs(slope(2, :) - 2) < 1d-11), &
        'the gradient of numbers')
    call simulation%divergence(PERION_OPERATOR_REFERENCE_DEFORMED, field, scalar)
    call assert(all(abs(scalar - 4) < 1d-11), 'the divergence of vectors')
    tensor(1, :, :) = field
    tensor(2, :, :) = place
    tensor(3, 1, :) = 5 * place(1, :)
    tensor(3, 2, :) = 7
    call simulation%divergence(PERION_OPERATOR_CURRENT_UNDEFORMED, tensor, rows_of)
    do point = 1, plate_count
      call assert(all(abs(rows_of(:, point) - [4d0, 2d0, 5d0]) < 1d-11), 'the divergence of tensors')
    end do
    scalar = -7
    call simulation%divergence(PERION_OPERATOR_CURRENT_DEFORMED, field(:, 2:), scalar, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "'field' has the shape (2,143) and 'result' (144); of 144 points in 2 dimensions they need (2,144) and (144)")
    call simulation%divergence(5_c_int32_t, field, scalar, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'operator' is 5")
    field(2, 7) = ieee_value(1d0, ieee_quiet_nan)
    call simulation%divergence(PERION_OPERATOR_CURRENT_DEFORMED, field, scalar, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' of point 6, component 1, is NaN")
    call assert(all(same_bits(scalar, -7d0)), 'a refused call has written its output')
    call simulation%gradient(PERION_OPERATOR_CURRENT_DEFORMED, place, gradient(:, :1, :), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'result' (2,1,144)")
    call simulation%gradient(PERION_OPERATOR_CURRENT_DEFORMED, place(1, 2:), slope, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' has the shape (143)")
    call simulation%divergence(PERION_OPERATOR_CURRENT_DEFORMED, tensor, rows_of(:2, :), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "need (2,2,144)")
    call simulation%destroy()
  end subroutine operators

  subroutine every_field()
    real(c_double) :: vector(2, plate_count), scalar(plate_count), tensor(2, 2, plate_count)
    type(perion_simulation) :: simulation
    integer :: k

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    do k = 1, size(vectors)
      vector = huge(vector)
      call simulation%get(vectors(k), vector)
      call assert(all(abs(vector) < 100), 'a vector is too large, or was not filled')
    end do
    do k = 1, size(scalars)
      scalar = huge(scalar)
      call simulation%get(scalars(k), scalar)
      call assert(all(abs(scalar) < 100), 'a scalar is too large, or was not filled')
      call assert(all(scalar >= 0) .or. scalars(k) == PERION_FIELD_STRESS_33 .or. &
          scalars(k) == PERION_FIELD_DILATATION, 'a scalar is negative')
      if (scalars(k) == PERION_FIELD_DAMAGE) then
        call assert(any(scalar > 0) .and. all(scalar <= 1), 'damage lies between 0 and 1')
      end if
    end do
    do k = 1, size(tensors)
      tensor = huge(tensor)
      call simulation%get(tensors(k), tensor)
      call assert(all(abs(tensor) < 100), 'a tensor is too large, or was not filled')
    end do
    call simulation%destroy()
  end subroutine every_field

  !> All numbers that fields have or may get: each is known here, or refused by the library.
  subroutine shapes()
    real(c_double) :: vector(2, plate_count), scalar(plate_count), tensor(2, 2, plate_count)
    real(c_double) :: four(2, 2), two(2), one
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    integer(c_int32_t) :: field

    call make_plate(simulation, brittle=.false.)
    call simulation%evaluate()
    vector = -7
    scalar = -7
    tensor = -7
    do field = 0, 100
      if (any(field == vectors)) then
        call simulation%get(field, scalar, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, "'values' has the shape (144); field")
        call simulation%sum(field, one, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'adds up to 2')
        call simulation%sum(field, two)
        call simulation%get(field, tensor, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (2,2,144)')
        call simulation%sum(field, four, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'adds up to 2')
      else if (any(field == tensors)) then
        call simulation%get(field, scalar, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'needs (2,2,144)')
        call simulation%get(field, vector, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'needs (2,2,144)')
        call simulation%sum(field, one, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'adds up to 4')
        call simulation%sum(field, two, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'adds up to 4')
        call simulation%sum(field, four)
      else if (any(field == scalars)) then
        call simulation%get(field, tensor, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'needs (144)')
        call simulation%sum(field, four, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'adds up to 1')
        call simulation%get(field, vector, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'needs (144)')
        call simulation%sum(field, two, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, 'adds up to 1')
        call simulation%sum(field, one)
      else
        call simulation%get(field, scalar, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' is")
        call simulation%get(field, vector, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' is")
        call simulation%get(field, tensor, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' is")
        call simulation%sum(field, four, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' is")
        call simulation%sum(field, one, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' is")
        call simulation%sum(field, two, error=error)
        call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' is")
      end if
    end do
    call assert(all(same_bits(vector, -7d0)) .and. all(same_bits(scalar, -7d0)) .and. &
        all(same_bits(tensor, -7d0)), 'a refused call has written its output')
    call simulation%destroy()
  end subroutine shapes

  subroutine nonsense_is_refused()
    real(c_double) :: values(6, plate_count + 1), sums(3)
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    type(state) :: before, after

    call make_plate(simulation, brittle=.false.)
    call simulation%evaluate()
    call take_state(simulation, before)
    values = 0.001d0
    associate (right => values(:2, :plate_count))
      call simulation%get(PERION_FIELD_VELOCITY, values(:2, 3:), error=error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, &
          "perion_simulation_get: 'values' has the shape (2,143); field 4 needs (2,144)")
      call simulation%get(PERION_FIELD_VELOCITY, values(:, :plate_count), error=error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (6,144)')
      call simulation%get(PERION_FIELD_VELOCITY, values(:0, :plate_count), error=error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (0,144)')
      call simulation%get(PERION_FIELD_VELOCITY, values(:2, :0), error=error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (2,0)')
      call simulation%get(PERION_FIELD_VELOCITY, values(:2, :0), 'left', error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, "'count' is 0")
      call simulation%get(PERION_FIELD_VELOCITY, values(:2, :8), 'left', error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, "'count' is 8")
      call simulation%get(PERION_FIELD_VELOCITY, values(:3, :9), 'left', error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (3,9); field 4 needs (2,count)')
      call simulation%get(PERION_FIELD_VELOCITY, values(:2, :9), 'lefft', error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, "'left'?")
      call simulation%get(PERION_FIELD_DAMAGE, values(1, :), error=error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (145); field 11 needs (144)')
      call assert(all(same_bits(values, 0.001d0)), 'a refused call has written its output')

      call simulation%set(PERION_FIELD_REACTION, right, error=error)
      call assert_fails(error, PERION_ERROR_UNSUPPORTED, 'reaction cannot be set')
      call simulation%set(PERION_FIELD_DAMAGE, values(1, :plate_count), error=error)
      call assert_fails(error, PERION_ERROR_UNSUPPORTED, 'damage cannot be set')
      call simulation%set(PERION_FIELD_DAMAGE, values(1, plate_count:1:-1), error=error)
      call assert_fails(error, PERION_ERROR_UNSUPPORTED, 'damage cannot be set')
      call simulation%set(PERION_FIELD_VELOCITY, values(:3, :plate_count), error=error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'shape (3,144)')
      call simulation%set(PERION_FIELD_VELOCITY, values(:2, :9), 'lefft', error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, "'left'?")
      values(1, 7) = nan()
      call simulation%set(PERION_FIELD_VELOCITY, right, error=error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'NaN')
      call simulation%set(PERION_FIELD_VELOCITY, values(:2, :9), 'left', error)
      call assert_fails(error, PERION_ERROR_ARGUMENT, 'NaN')
    end associate
    sums = -7
    call simulation%sum(PERION_FIELD_VELOCITY, sums, error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'components' has 3 numbers; field 4 adds up to 2")
    call simulation%sum(PERION_FIELD_VELOCITY, sums(:2), 'lefft', error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'left'?")
    call assert(all(same_bits(sums, -7d0)), 'a refused sum has written its output')
    call take_state(simulation, after)
    call assert(same(before, after), 'a refused call has changed the simulation')
    call simulation%destroy()
  end subroutine nonsense_is_refused

end module fields_tests
