!> Points: from the host's arrays and as a block, their sets and horizons.
module points_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_points

  character(*), parameter :: file = 'points.f90'

contains

  subroutine test_points()
    call run(file, 'a host array of six numbers a point needs no packing', strided_arrays)
    call run(file, 'a block has a point in the middle of each cell, x fastest', block_is_a_lattice)
    call run(file, 'sets keep the order of their points', sets_keep_order)
    call run(file, 'a box names the points within it', boxes_name_points)
    call run(file, 'what makes no sense is refused and changes nothing', nonsense_is_refused)
    call run(file, 'horizons of their own give points other families', own_horizons)
    call run(file, 'a file of points is read with its sets', files_are_read)
    call run(file, 'destroying sets the handle to null, twice is fine', destroying_twice)
  end subroutine test_points

  subroutine strided_arrays()
    integer(c_int64_t), parameter :: n = 5
    real(c_double) :: host(6, n), volumes(n), back(3, n), volumes_back(n)
    type(c_ptr) :: points
    integer(c_int64_t) :: count
    integer(c_int32_t) :: dimension
    integer :: k

    ! Rows 4 to 6 hold something else of the host's; here they stay signalling NaN.
    do k = 1, int(n)
      host(1:3, k) = [0.1_c_double * k, 0.2_c_double * k * k, -0.3_c_double * k]
      volumes(k) = 1.0_c_double / k
    end do
    points = c_null_ptr
    call assert_ok(perion_points_create(3, n, host, 6_c_int64_t, volumes, points))
    call assert_ok(perion_points_count(points, count))
    call assert_ok(perion_points_dimension(points, dimension))
    call assert(count == n .and. dimension == 3, 'count or dimension differs')
    call assert_ok(perion_points_get_coordinates(points, back, 3 * n))
    call assert_ok(perion_points_get_volumes(points, volumes_back, n))
    call assert(all(same_bits(back, host(1:3, :))), 'the coordinates differ')
    call assert(all(same_bits(volumes_back, volumes)), 'the volumes differ')
    call assert_ok(perion_points_destroy(points))
  end subroutine strided_arrays

  subroutine block_is_a_lattice()
    real(c_double) :: coordinates(2, columns, rows), volumes(plate_count)
    type(c_ptr) :: points
    integer :: column, row

    points = c_null_ptr
    call make_plate_points(points)
    call assert_ok(perion_points_get_coordinates(points, coordinates, 2 * plate_count))
    call assert_ok(perion_points_get_volumes(points, volumes, plate_count))
    do row = 1, rows
      do column = 1, columns
        ! Halves are exact.
        call assert(all(same_bits(coordinates(:, column, row), &
            [column - 0.5_c_double, row - 0.5_c_double])), 'a point is not where it should be')
      end do
    end do
    call assert(all(same_bits(volumes, 1.0_c_double)), 'a volume is not spacing^2')
    call assert_ok(perion_points_destroy(points))
  end subroutine block_is_a_lattice

  subroutine sets_keep_order()
    ! Points 10, 3 and 144 as Fortran counts, one less in C.
    integer(c_int64_t), parameter :: members(3) = [10, 3, 144]
    integer(c_int64_t) :: back(3), all_points(plate_count), size_of_set, k
    type(c_ptr) :: points

    points = c_null_ptr
    call make_plate_points(points)
    call assert_ok(perion_points_add_set(points, c('probes'), 3_c_int64_t, members - 1))
    call assert_ok(perion_points_set_size(points, c('probes'), size_of_set))
    call assert(size_of_set == 3, 'the size of the set differs')
    call assert_ok(perion_points_get_set(points, c('probes'), 3_c_int64_t, back))
    call assert(all(back + 1 == members), 'the set has other points, or another order')
    call assert_ok(perion_points_get_set(points, c('all'), plate_count, all_points))
    call assert(all(all_points == [(k, k = 0, plate_count - 1)]), 'the set "all" is not all')
    call assert_ok(perion_points_destroy(points))
  end subroutine sets_keep_order

  subroutine boxes_name_points()
    integer(c_int64_t) :: right(rows), size_of_set, row
    type(c_ptr) :: points

    points = c_null_ptr
    call make_plate_points(points)
    call assert_ok(perion_points_set_size(points, c('right'), size_of_set))
    call assert(size_of_set == rows, 'the right edge has another number of points')
    call assert_ok(perion_points_get_set(points, c('right'), size_of_set, right))
    call assert(all(right + 1 == [(row * columns, row = 1, rows)]), 'other points are at the right')
    call assert_refused(perion_points_add_set_box(points, c('nowhere'), &
        [-9.0_c_double, -9.0_c_double], [-8.0_c_double, -8.0_c_double]), PERION_ERROR_ARGUMENT, &
        "'nowhere'")
    call assert_ok(perion_points_destroy(points))
  end subroutine boxes_name_points

  subroutine nonsense_is_refused()
    real(c_double) :: host(3, 2), volumes(2)
    integer(c_int64_t) :: size_of_set
    type(c_ptr) :: points

    host = reshape([0, 0, 0, 1, 1, 1], [3, 2])
    volumes = 1
    points = c_null_ptr
    call assert_refused(perion_points_create(3, 2_c_int64_t, host, 2_c_int64_t, volumes, points), &
        PERION_ERROR_ARGUMENT, "'stride' is 2")
    call assert_refused(perion_points_create(3, -2_c_int64_t, host, 3_c_int64_t, volumes, points), &
        PERION_ERROR_ARGUMENT, "'count' is -2")
    call assert_refused(perion_points_create(4, 2_c_int64_t, host, 4_c_int64_t, volumes, points), &
        PERION_ERROR_ARGUMENT, "'dimension' is 4")
    volumes(2) = 0
    call assert_refused(perion_points_create(3, 2_c_int64_t, host, 3_c_int64_t, volumes, points), &
        PERION_ERROR_ARGUMENT, "'volumes' of point 1")
    call assert(.not. c_associated(points), 'a refused call has made points')

    call make_plate_points(points)
    call assert_refused(perion_points_add_set(points, c('wrong'), 1_c_int64_t, [plate_count]), &
        PERION_ERROR_ARGUMENT, "'indices'[0] is 144")
    call assert_refused(perion_points_add_set(points, c('left'), 1_c_int64_t, [0_c_int64_t]), &
        PERION_ERROR_ARGUMENT, "'left' exists already")
    call assert_refused(perion_points_set_size(points, c('wrong'), size_of_set), &
        PERION_ERROR_ARGUMENT, "unknown set 'wrong'")
    call assert_ok(perion_points_destroy(points))
  end subroutine nonsense_is_refused

  subroutine own_horizons()
    real(c_double) :: horizons(plate_count), neighbors(columns, rows)
    type(c_ptr) :: points, model, simulation

    points = c_null_ptr
    model = c_null_ptr
    simulation = c_null_ptr
    call make_plate_points(points)
    call make_material(model, brittle=.false.)
    ! The lower rows reach the four nearest neighbours alone.
    horizons = 3.015_c_double
    horizons(:4 * columns) = 1.1_c_double
    call assert_refused(perion_points_set_horizons(points, plate_count - 1, horizons), &
        PERION_ERROR_ARGUMENT, "'count' is 143")
    call assert_ok(perion_points_set_horizons(points, plate_count, horizons))
    call assert_ok(perion_simulation_create(points, model, simulation))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_NEIGHBOR_COUNT, neighbors, &
        plate_count))
    call assert(nint(neighbors(8, 2)) == 4, 'a point in the lower rows has not 4 neighbours')
    ! 28 points lie within 3.015 spacings; the top rows lack those beyond the edge.
    call assert(nint(neighbors(8, 6)) == 28, 'a point in the upper rows has not 28 neighbours')
    call destroy(simulation)
    call assert_ok(perion_model_destroy(model))
    call assert_ok(perion_points_destroy(points))
  end subroutine own_horizons

  subroutine files_are_read()
    type(c_ptr) :: points, model, simulation
    character(kind=c_char) :: name(PERION_NAME_CAPACITY)
    character(:), allocatable :: path
    integer(c_int64_t) :: count
    integer(c_int32_t) :: dimension
    integer :: unit

    path = temporary_directory // '/cloud.txt'
    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') '0 0 0 7 0.5', '1 0 0 7 0.5'
    close (unit)
    points = c_null_ptr
    model = c_null_ptr
    simulation = c_null_ptr
    call assert_ok(perion_points_read(path // c_null_char, points))
    call assert_ok(perion_points_set_count(points, count))
    call assert(count == 1, 'there is one set')
    call assert_ok(perion_points_get_set_name(points, 0_c_int64_t, name, PERION_NAME_CAPACITY + 0_c_int64_t))
    call assert(all(name(:8) == [character(kind=c_char) :: 'b', 'l', 'o', 'c', 'k', '_', '7', c_null_char]), &
        'the set has another name')
    call assert_ok(perion_model_create('bond_based' // c_null_char, model))
    call assert_ok(perion_model_set(model, 'density' // c_null_char, 1d0))
    call assert_ok(perion_model_set(model, 'youngs_modulus' // c_null_char, 1d0))
    call assert_ok(perion_model_set(model, 'horizon' // c_null_char, 2d0))
    call assert_ok(perion_simulation_create(points, model, simulation))
    call assert_ok(perion_simulation_point_count(simulation, count))
    call assert_ok(perion_simulation_dimension(simulation, dimension))
    call assert(count == 2 .and. dimension == 3, 'count or dimension differs')
    call assert_ok(perion_simulation_destroy(simulation))
    call assert_ok(perion_model_destroy(model))
    call assert_ok(perion_points_destroy(points))
  end subroutine files_are_read

  subroutine destroying_twice()
    type(c_ptr) :: points

    points = c_null_ptr
    call make_plate_points(points)
    call assert_ok(perion_points_destroy(points))
    call assert(.not. c_associated(points), 'the handle is not null')
    call assert_ok(perion_points_destroy(points))
  end subroutine destroying_twice

end module points_tests
