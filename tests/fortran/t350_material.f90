!> Laws of the host's own: what they are asked, what they remember, how they stop, and how long they live.
module material_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes, only: pattern
  use testing
  implicit none
  private
  public :: test_material

  character(*), parameter :: file = 't350_material'
  real(c_double), parameter :: youngs_modulus = 1, poissons_ratio = 0.3d0
  integer, parameter :: across(3) = [5, 4, 4]

  !> Saint Venant and Kirchhoff's, which counts commits in its state, if it has one.
  type, extends(perion_material) :: elastic
    integer :: calls = 0, stop_at = huge(1), state_size = 1
    real(c_double) :: fewest = -1, most = -1
    logical :: is_at_rest = .false., shapes_hold = .true.
  contains
    procedure :: answer => answer_elastic
  end type elastic

contains

  subroutine test_material()
    call run(file, 'Saint Venant and Kirchhoff''s law is the built-in one', as_built_in)
    call run(file, 'a state is kept when it is committed', states_are_kept)
    call run(file, 'a law that stops ends what asks it', law_stops)
    call run(file, 'laws that cannot be are refused', refusals)
    call run(file, 'a law serves points of one dimension at a time', one_dimension)
    call run(file, 'a law lives as long as its model and the simulations made of it', lives)
  end subroutine test_material

  subroutine answer_elastic(self, F0, F1, state0, state1, P, W, stop)
    class(elastic), intent(inout) :: self
    real(c_double), intent(in) :: F0(:, :, :), F1(:, :, :)
    real(c_double), intent(in) :: state0(:, :)
    real(c_double), intent(inout) :: state1(:, :)
    real(c_double), intent(inout) :: P(:, :, :)
    real(c_double), intent(inout) :: W(:)
    logical, intent(inout) :: stop
    real(c_double), dimension(size(F1, 1), size(F1, 1)) :: identity, H, strain
    real(c_double) :: mu, lambda, trace
    integer :: k, n, axis

    n = size(F1, 1)
    mu = youngs_modulus / (2 * (1 + poissons_ratio))
    lambda = 2 * mu * poissons_ratio / (1 - 2 * poissons_ratio)
    identity = 0
    do axis = 1, n
      identity(axis, axis) = 1
    end do
    self%shapes_hold = self%shapes_hold .and. all(shape(P) == shape(F1)) .and. all(shape(F0) == shape(F1)) &
        .and. size(W) == size(F1, 3) .and. all(shape(state0) == [self%state_size, size(W)]) &
        .and. all(shape(state1) == shape(state0))
    self%is_at_rest = all(abs(F0(:, :, 1) - identity) <= 0)
    do k = 1, size(W)
      H = F1(:, :, k) - identity
      strain = (H + transpose(H) + matmul(transpose(H), H)) / 2
      trace = 0
      do axis = 1, n
        trace = trace + strain(axis, axis)
      end do
      P(:, :, k) = lambda * trace * F1(:, :, k) + 2 * mu * matmul(F1(:, :, k), strain)
      W(k) = lambda * trace**2 / 2 + mu * sum(strain**2)
    end do
    if (size(state0, 1) > 0) then
      self%fewest = minval(state0(1, :))
      self%most = maxval(state0(1, :))
      state1(1, :) = state1(1, :) + 1
    end if
    self%calls = self%calls + 1
    stop = self%calls == self%stop_at
  end subroutine answer_elastic

  subroutine make_block(points, dimension)
    type(perion_points), intent(inout) :: points
    integer, intent(in) :: dimension
    real(c_double) :: upper(3)

    upper = across
    call points%create_block(0 * upper(:dimension), upper(:dimension), 1d0)
    call points%add_set_box('left', 0 * upper(:dimension), &
        [1d0, upper(2:dimension)])
  end subroutine make_block

  subroutine make_solid(model)
    type(perion_model), intent(inout) :: model

    call model%create('correspondence')
    call model%set('density', 1d0)
    call model%set('youngs_modulus', youngs_modulus)
    call model%set('poissons_ratio', poissons_ratio)
    call model%set('horizon', 2.1d0)
  end subroutine make_solid

  subroutine as_built_in()
    integer :: dimension, count
    type(elastic), target :: law
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: built_in, by_host
    type(perion_energy) :: energies(2)
    real(c_double), allocatable :: forces(:, :, :), moved(:, :)

    do dimension = 2, 3
      call make_block(points, dimension)
      call make_solid(model)
      call built_in%create(points, model)
      call model%set_material_function(1, law)
      call by_host%destroy()
      call by_host%create(points, model)
      count = product(across(:dimension))
      moved = 50 * pattern(dimension, count)
      allocate (forces(dimension, count, 2))
      call built_in%set(PERION_FIELD_DISPLACEMENT, moved)
      call by_host%set(PERION_FIELD_DISPLACEMENT, moved)
      call built_in%get(PERION_FIELD_INTERNAL_FORCE, forces(:, :, 1))
      call by_host%get(PERION_FIELD_INTERNAL_FORCE, forces(:, :, 2))
      call built_in%energy(energies(1))
      call by_host%energy(energies(2))
      ! F = I + H rounds strains of some hundredths to 1e-14 of them.
      call assert(maxval(abs(forces(:, :, 1))) > 1d-3, 'there is no force to compare')
      call assert(maxval(abs(forces(:, :, 2) - forces(:, :, 1))) <= 1d-13 * maxval(abs(forces)), &
          'the forces differ')
      call assert(close_to(energies(2)%elastic, energies(1)%elastic, 1d-13 * energies(1)%elastic), &
          'the energies differ')
      deallocate (forces)
    end do
    call assert(law%calls > 0 .and. law%shapes_hold, 'an array has another shape')
  end subroutine as_built_in

  subroutine states_are_kept()
    type(elastic), target :: law
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_energy) :: energy
    real(c_double) :: time_step

    call make_block(points, 3)
    call make_solid(model)
    call model%set_material_function(1_int64, law)
    call simulation%create(points, model)
    call simulation%set(PERION_FIELD_DISPLACEMENT, pattern(3, product(across)))
    call simulation%evaluate()
    call simulation%stable_time_step(time_step)
    call assert(law%is_at_rest .and. law%most <= 0, 'something was kept without a commit')
    call simulation%commit(0d0)
    call simulation%energy(energy)
    call assert(.not. law%is_at_rest, 'F0 is not that of the commit')
    call assert(close_to(law%fewest, 1d0, 0d0) .and. close_to(law%most, 1d0, 0d0), &
        'a commit has not kept the state')
    call simulation%step(0.25d0 * time_step, 4)
    call simulation%energy(energy)
    call simulation%energy(energy)
    call assert(close_to(law%fewest, 5d0, 0d0) .and. close_to(law%most, 5d0, 0d0), &
        'a step has not kept the state')
  end subroutine states_are_kept

  subroutine law_stops()
    integer :: steps
    type(elastic), target :: law
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_block(points, 3)
    call make_solid(model)
    call model%set_material_function(1, law)
    call simulation%create(points, model)
    call simulation%evaluate()
    law%stop_at = law%calls + 1
    call simulation%step(0.01d0, 3, error)
    call assert_fails(error, PERION_ERROR_INTERRUPTED, 'the material''s function asked to stop')
    call simulation%step_count(steps)
    call assert(steps == 0, 'a step was made')
    call simulation%step(0.01d0, 3)
  end subroutine law_stops

  subroutine refusals()
    type(elastic), target :: law
    type(perion_model) :: model
    type(perion_error), allocatable :: error

    call model%set_material_function(0, law, error)
    call assert_fails(error, PERION_ERROR_NULL, 'the perion_model has not been created')
    call make_solid(model)
    call model%set_material_function(-1, law, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'state_size' is -1")
    call model%set_material_function(100001_int64, law, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'state_size' is 100001")
    call model%create('bond_based')
    call model%set_material_function(0, law, error)
    call assert_fails(error, PERION_ERROR_UNSUPPORTED, "'material'")
  end subroutine refusals

  subroutine one_dimension()
    type(elastic), target :: law
    type(perion_points) :: plate, block
    type(perion_model) :: model, other
    type(perion_simulation) :: simulation, second
    type(perion_error), allocatable :: error

    law%state_size = 0
    call make_block(plate, 2)
    call make_block(block, 3)
    call make_solid(model)
    call model%set_material_function(0, law)
    call simulation%create(plate, model)
    call second%create(block, model, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "the law of 'model' is in use for points of dimension 2, and here they have 3")
    call make_solid(other)
    call second%create(block, other)
    call second%assign_model('left', model, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'perion_simulation_assign_model: the law')
    ! Through a model of its own the same law serves both.
    call other%set_material_function(0, law)
    call second%create(block, other)
    call simulation%evaluate()
    call second%evaluate()
    call simulation%evaluate()
    call simulation%destroy()
    call second%create(block, model)
    call second%evaluate()
    call assert(law%shapes_hold, 'an array has another shape')
  end subroutine one_dimension

  !> Valgrind watches over the holders.
  subroutine lives()
    type(elastic), target :: first, second
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: one, other
    type(perion_error), allocatable :: error
    integer :: calls

    call make_block(points, 3)
    call make_solid(model)
    call model%set_material_function(1, first)
    call one%create(points, model)
    call other%create(points, model)
    call model%set_material_function(1, second)
    call other%assign_model('left', model)
    call other%assign_model('right', model, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'right'")
    call model%destroy()
    call one%evaluate()
    calls = first%calls
    call assert(calls > 0 .and. second%calls == 0, 'the replaced law is not that of its simulation')
    call one%destroy()
    call other%evaluate()
    call assert(first%calls > calls .and. second%calls > 0, 'a law is not asked')
    call make_solid(model)
    call model%set_material_function(1, first)
    call other%create(points, model)
    ! What has a law and goes out of scope is freed: other first, or the model.
  end subroutine lives

end module material_tests
