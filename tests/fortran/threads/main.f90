!> Threads of the host, each with objects of its own but for a model, and with it a law, that they share: compiled
!> with OpenMP. Prints whether all have had the same results.
module threads_host
  use perion
  implicit none
  private
  public :: spring

  !> P = F - I; without a component that it changes, it can be asked by several threads.
  type, extends(perion_material) :: spring
  contains
    procedure :: answer => answer_spring
  end type spring

contains

  recursive subroutine answer_spring(self, F0, F1, state0, state1, P, W, stop)
    class(spring), intent(inout) :: self
    double precision, intent(in) :: F0(:, :, :), F1(:, :, :), state0(:, :)
    double precision, intent(inout) :: state1(:, :), P(:, :, :), W(:)
    logical, intent(inout) :: stop
    integer :: axis, k

    stop = size(F0) /= size(F1) .or. size(state0) /= size(state1) .or. .not. same_type_as(self, self)
    P = F1
    do k = 1, size(W)
      do axis = 1, size(P, 1)
        P(axis, axis, k) = P(axis, axis, k) - 1
      end do
      W(k) = sum(P(:, :, k)**2) / 2
    end do
  end subroutine answer_spring

end module threads_host

program threads
  use perion
  use threads_host
  implicit none
  integer, parameter :: lives = 16
  double precision :: energies(lives)
  integer :: k
  type(spring), target :: law
  type(perion_model) :: shared_model

  call shared_model%create('correspondence')
  call shared_model%set('density', 1d0)
  call shared_model%set('youngs_modulus', 1d0)
  call shared_model%set('poissons_ratio', 0.25d0)
  call shared_model%set('horizon', 2.015d0)
  call shared_model%set_material_function(1, law)
  !$omp parallel do num_threads(2) schedule(dynamic)
  do k = 1, lives
    call live(energies(k))
  end do
  print '(l1)', all(abs(energies - energies(1)) <= 0) .and. energies(1) > 0

contains

  recursive subroutine live(energy)
    double precision, intent(inout) :: energy
    double precision :: held
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: bar, of_shared
    type(perion_error), allocatable :: error
    integer :: turn

    do turn = 1, 20
      call points%create_block([0d0, 0d0], [8d0, 4d0], 1d0)
      call points%add_set_box('end', [0d0, 0d0], [1d0, 4d0])
      call model%create('bond_based')
      call model%set('density', 1d0)
      call model%set('youngs_modulus', 1d0)
      call model%set('horizon', 2.015d0)
      call bar%create(points, model)
      call bar%set_threads(1)
      call bar%prescribe('end', PERION_QUANTITY_VELOCITY, 1, 0.01d0)
      call bar%step(0.2d0, 10)
      call bar%step(-0.2d0, 10, error)
      if (.not. allocated(error)) error stop 'a negative step is made'
      if (index(error%message, '''time_step'' is -0.2') == 0) error stop 'another thread''s text'
      call of_shared%create(points, shared_model)
    end do
    call of_shared%set_threads(1)
    call of_shared%prescribe('end', PERION_QUANTITY_VELOCITY, 1, 0.01d0)
    call of_shared%step(0.2d0, 10)
    call of_shared%sum(PERION_FIELD_STRAIN_ENERGY_DENSITY, held)
    call bar%sum(PERION_FIELD_STRAIN_ENERGY_DENSITY, energy)
    energy = energy + held
  end subroutine live

end program threads
