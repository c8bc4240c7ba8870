!> Points: made of the host's arrays or as a block, with sets and horizons.
module points_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_points

  character(*), parameter :: file = 't200_points'
  character(*), parameter :: from_zero = ' (points and axes in this text count from 0)'

contains

  subroutine test_points()
    call run(file, 'sections of a host''s array, of whatever stride, are its points', host_arrays)
    call run(file, 'a block has a point in the middle of each cell, x fastest', block_is_a_lattice)
    call run(file, 'sets keep the order of their points and count from 1', sets_keep_order)
    call run(file, 'a box names the points within it', boxes_name_points)
    call run(file, 'horizons of their own give points other families', own_horizons)
    call run(file, 'a file of points is read with its sets', files_are_read)
    call run(file, 'what cannot be made is refused and leaves what was there', refused_creation)
    call run(file, 'sets that make no sense are refused', refused_sets)
    call run(file, 'arrays of another shape are refused', refused_shapes)
    call run(file, 'points that were not created are refused', not_created)
  end subroutine test_points

  subroutine host_arrays()
    integer, parameter :: n = 5
    real(c_double) :: host(6, n), wide(7, 2 * n), volumes(2 * n), expected(3, n)
    integer :: k

    ! What is not set stays signalling NaN, which traps when it is touched.
    do k = 1, n
      expected(:, k) = [0.1d0 * k, 0.2d0 * k * k, -0.3d0 * k]
    end do
    volumes = 0
    volumes(::2) = [(1d0 / k, k = 1, n)]
    host(1:3, :) = expected
    call expect(host(1:3, :), volumes(::2), expected)
    host(4:6, :) = expected
    call expect(host(4:6, :), volumes(::2), expected)
    ! Neither neighbours nor in order: copies.
    wide(1:5:2, ::2) = expected
    call expect(wide(1:5:2, ::2), volumes(::2), expected)
    call expect(expected(:, n:1:-1), volumes(::2), expected(:, n:1:-1))
    call expect(expected(3:1:-1, :), volumes(::2), expected(3:1:-1, :))
    call expect(expected([1, 2, 3], :), volumes(::2), expected)
    call expect(expected(:, 2:2), volumes(3:3), expected(:, 2:2))
  end subroutine host_arrays

  subroutine expect(coordinates, volumes, expected)
    real(c_double), intent(in) :: coordinates(:, :), volumes(:), expected(:, :)
    type(perion_points) :: points
    integer :: count, dimension
    integer(int64) :: wide_count, wide_dimension
    real(c_double) :: back(6, size(expected, 2)), volumes_back(2, size(volumes))

    call points%create(coordinates, volumes)
    call points%count(count)
    call points%count(wide_count)
    call points%dimension(dimension)
    call points%dimension(wide_dimension)
    call assert(count == size(expected, 2) .and. wide_count == count, 'the count differs')
    call assert(dimension == 3 .and. wide_dimension == 3, 'the dimension differs')
    call points%get_coordinates(back(4:6, :))
    call points%get_volumes(volumes_back(2, :))
    call assert(all(same_bits(back(4:6, :), expected)), 'the coordinates differ')
    call assert(all(same_bits(volumes_back(2, :), volumes)), 'the volumes differ')
    call points%destroy()
  end subroutine expect

  subroutine block_is_a_lattice()
    real(c_double) :: coordinates(2, plate_count), volumes(plate_count)
    type(perion_points) :: points
    integer :: column, row

    call make_points(points)
    call points%get_coordinates(coordinates)
    call points%get_volumes(volumes)
    do row = 1, rows
      do column = 1, columns
        ! Halves are exact.
        call assert(all(same_bits(coordinates(:, column + columns * (row - 1)), &
            [column - 0.5d0, row - 0.5d0])), 'a point is not where it should be')
      end do
    end do
    call assert(all(same_bits(volumes, 1d0)), 'a volume is not spacing**2')
    call points%destroy()
  end subroutine block_is_a_lattice

  subroutine sets_keep_order()
    integer, parameter :: members(3) = [10, 3, 144]
    type(perion_points) :: points
    integer :: back(3), size_of_set, k
    integer(int64) :: wide(3), all_points(plate_count), wide_size

    call make_points(points)
    call points%add_set('probes', members)
    call points%add_set('probes again', int(members, int64))
    call points%set_size('probes', size_of_set)
    call points%set_size('probes again', wide_size)
    call assert(size_of_set == 3 .and. wide_size == 3, 'the size of a set differs')
    call points%get_set('probes again  ', back)
    call points%get_set('probes', wide)
    call assert(all(back == members), 'the set has other points, or another order')
    call assert(all(wide == members), 'the set of 64 bits has other points, or another order')
    call points%get_set('all', all_points)
    call assert(all(all_points == [(k, k = 1, plate_count)]), 'the set all is not all')
    call points%destroy()
  end subroutine sets_keep_order

  subroutine boxes_name_points()
    type(perion_points) :: points
    type(perion_error), allocatable :: error
    integer :: right(rows), row

    call make_points(points)
    call points%get_set('right', right)
    call assert(all(right == [(row * columns, row = 1, rows)]), 'other points are at the right')
    call points%add_set_box('nowhere', [-9d0, -9d0], [-8d0, -8d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'nowhere'")
    call points%add_set_box('flat', [0d0], [1d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'the points have 2 axes')
    call points%destroy()
  end subroutine boxes_name_points

  subroutine own_horizons()
    real(c_double) :: horizons(plate_count), neighbors(plate_count)
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_points(points)
    call make_model(model, brittle=.false.)
    horizons(:4 * columns) = 1.25d0
    horizons(4 * columns + 1:) = 3.015d0
    call points%set_horizons(horizons(2:), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'count' is 143")
    call points%set_horizons(-horizons, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'horizons'")
    call points%set_horizons(horizons)
    call simulation%create(points, model)
    call simulation%get(PERION_FIELD_NEIGHBOR_COUNT, neighbors)
    call assert(nint(neighbors(8 + columns)) == 4, 'a point in the lower rows has not 4 neighbours')
    ! 28 points lie within 3.015 spacings; the upper rows lack those beyond the edge.
    call assert(nint(neighbors(8 + 5 * columns)) == 28, &
        'a point in the upper rows has not 28 neighbours')
    call simulation%destroy()
    call model%destroy()
    call points%destroy()
  end subroutine own_horizons

  subroutine files_are_read()
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    character(:), allocatable :: path, name
    real(c_double) :: coordinates(3, 2)
    integer :: count, dimension, unit
    integer(int64) :: wide, wide_dimension

    path = temporary_directory // '/cloud.txt'
    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') '0 0 0 7 0.5', '1 0 0 12 0.5'
    close (unit)
    call points%read(path // '  ')
    call points%get_coordinates(coordinates)
    call assert(all(same_bits(coordinates(:, 2), [1d0, 0d0, 0d0])), 'the second point is elsewhere')
    call points%set_count(count)
    call points%set_count(wide)
    call assert(count == 2 .and. wide == 2, 'there are not two sets')
    call points%get_set_name(1, name)
    call assert(name == 'block_12', 'the first set is ' // name)
    call points%get_set_name(2_int64, name)
    call assert(name == 'block_7' .and. len(name) == 7, 'the second set is ' // name)
    call points%get_set_name(3, name, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "perion_points_get_set_name: 'index' is 3; sets are 1 to 2")
    call points%get_set_name(0_int64, name, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'index' is 0")
    call assert(name == 'block_7', 'a refused call has written its output')

    call make_model(model, brittle=.false.)
    call simulation%create(points, model)
    call simulation%point_count(count)
    call simulation%point_count(wide)
    call simulation%dimension(dimension)
    call simulation%dimension(wide_dimension)
    call assert(count == 2 .and. wide == 2, 'the simulation has not two points')
    call assert(dimension == 3 .and. wide_dimension == 3, 'the simulation has not three axes')

    call points%read(temporary_directory // '/nowhere.txt', error)
    call assert_fails(error, PERION_ERROR_IO, 'nowhere.txt')
    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') '0 0 0 7 0.5', '1 0 zero 12 0.5'
    close (unit)
    call points%read(path, error)
    call assert_fails(error, PERION_ERROR_FORMAT, 'zero')
    call points%count(count)
    call assert(count == 2, 'a refused call has changed the points')
    call simulation%destroy()
    call model%destroy()
    call points%destroy()
  end subroutine files_are_read

  subroutine refused_creation()
    real(c_double) :: coordinates(3, 2), volumes(2)
    type(perion_points) :: points
    type(perion_error), allocatable :: error
    integer :: count

    coordinates = reshape([0, 0, 0, 1, 1, 1], [3, 2])
    volumes = 1
    call make_points(points)
    call points%create(reshape(coordinates, [1, 6]), [volumes, volumes, volumes], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'dimension' is 1")
    call points%create(coordinates(:0, :1), volumes(:1), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "perion_points_create: 'dimension' is 0")
    call points%create(reshape([coordinates, coordinates], [4, 3]), [volumes, volumes], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "'coordinates' has the shape (4,3); it must be (dimension,count) - transposed?")
    call points%create(coordinates, volumes(:1), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'volumes' has 1 numbers for 2 points")
    call points%create(coordinates(:, :0), volumes(:0), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'count' is 0")
    call points%create(coordinates([1, 1], [1, 1]), volumes, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'points 0 and 1 stand in one place' // from_zero)
    volumes(2) = 0
    call points%create(coordinates, volumes, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'volumes' of point 1 ")
    call assert_fails(error, PERION_ERROR_ARGUMENT, from_zero)
    coordinates(2, 2) = nan()
    call points%create(coordinates, volumes, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'of point 1, axis 1, is NaN')
    call assert_fails(error, PERION_ERROR_ARGUMENT, from_zero)
    call points%create_block([0d0, 0d0], [1d0, 1d0, 1d0], 1d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'lower' has 2 numbers and 'upper' 3")
    call points%create_block([0d0], [1d0], 1d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'dimension' is 1")
    call points%create_block([0d0, 0d0], [1d0, 1d0], -1d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'spacing' is -1")
    call points%count(count)
    call assert(count == plate_count, 'a refused call has changed the points')
    call points%destroy()
  end subroutine refused_creation

  subroutine refused_sets()
    type(perion_points) :: points
    type(perion_error), allocatable :: error
    integer :: members(2), size_of_set

    call make_points(points)
    call points%add_set('wrong', [1, 145], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'indices' names point 145; points are 1 to 144")
    call points%add_set('wrong', [0_int64], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'indices' names point 0")
    call points%add_set('wrong', [-huge(1_int64) - 1], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'indices' names point -9223372036854775808")
    call points%add_set('wrong', [3, 144, 3], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "perion_points_add_set: 'indices' names point 3 twice")
    call points%add_set('wrong', [144_int64, 144_int64], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'indices' names point 144 twice")
    call points%add_set('wrong', [integer ::], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'count' is 0")
    call points%add_set('left', [1], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'left' exists already")
    call points%add_set(' ', [1], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'empty')
    size_of_set = -7
    call points%set_size('wrong', size_of_set, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "unknown set 'wrong'")
    call assert(index(error%message, from_zero) == 0, 'a text without a point tells how points count')
    call assert(size_of_set == -7, 'a refused call has written its output')
    members = -7
    call points%get_set('left', members, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'count' is 2")
    call points%get_set('wrong', members, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "unknown set 'wrong'")
    call assert(all(members == -7), 'a refused call has written its output')
    call points%destroy()
  end subroutine refused_sets

  subroutine refused_shapes()
    real(c_double) :: coordinates(3, plate_count), volumes(plate_count + 1)
    type(perion_points) :: points
    type(perion_error), allocatable :: error

    call make_points(points)
    coordinates = -7
    volumes = -7
    call points%get_coordinates(coordinates, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "perion_points_get_coordinates: 'coordinates' has the shape (3,144), not (2,144)")
    call points%get_coordinates(coordinates(:2, 2:), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, '(2,143), not (2,144)')
    call points%get_volumes(volumes, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'length' is 145")
    call assert(all(same_bits(coordinates, -7d0)) .and. all(same_bits(volumes, -7d0)), &
        'a refused call has written its output')
    call points%destroy()
  end subroutine refused_shapes

  subroutine not_created()
    real(c_double) :: coordinates(2, 1)
    type(perion_points) :: points
    type(perion_error), allocatable :: error
    character(:), allocatable :: name
    integer(int64) :: count

    call points%destroy()
    call points%add_set('one', [1], error)
    call assert_fails(error, PERION_ERROR_NULL, &
        'perion_points_add_set: the perion_points has not been created')
    call points%add_set_box('one', [0d0], [1d0], error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_points_add_set_box')
    call points%set_horizons([1d0], error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_points_set_horizons')
    call points%dimension(count, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_points_dimension')
    call points%get_coordinates(coordinates, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_points_get_coordinates')
    call points%get_set_name(1, name, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_points_get_set_name')
    call make_points(points)
    call points%destroy()
    call points%count(count, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_points_count')
  end subroutine not_created

end module points_tests
