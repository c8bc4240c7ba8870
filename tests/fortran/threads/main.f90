!> Threads of the host, each with objects of its own: compiled with OpenMP. Prints whether all have
!> had the same results.
program threads
  use perion
  implicit none
  integer, parameter :: lives = 16
  double precision :: energies(lives)
  integer :: k

  !$omp parallel do num_threads(2) schedule(dynamic)
  do k = 1, lives
    call live(energies(k))
  end do
  print '(l1)', all(abs(energies - energies(1)) <= 0) .and. energies(1) > 0

contains

  recursive subroutine live(energy)
    double precision, intent(inout) :: energy
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: bar
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
    end do
    call bar%sum(PERION_FIELD_STRAIN_ENERGY_DENSITY, energy)
  end subroutine live

end program threads
