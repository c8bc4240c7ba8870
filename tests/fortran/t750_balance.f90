!> Energy, health and memory.
module balance_tests
  use, intrinsic :: iso_c_binding
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_balance

  character(*), parameter :: file = 't750_balance'

contains

  subroutine test_balance()
    call run(file, 'energies are the sums of their densities and balance the work', energies)
    call run(file, 'health tells broken bonds and detached points', health_tells)
    call run(file, 'memory is the sum of its parts', memory_adds_up)
    call run(file, 'a refused call leaves its output', refused)
  end subroutine test_balance

  subroutine energies()
    real(c_double) :: velocity(2, plate_count), elastic, dissipated, total
    type(perion_energy) :: energy
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call simulation%energy(energy)
    call simulation%get(PERION_FIELD_VELOCITY, velocity)
    call simulation%sum(PERION_FIELD_STRAIN_ENERGY_DENSITY, elastic)
    call simulation%sum(PERION_FIELD_DISSIPATED_ENERGY_DENSITY, dissipated)
    total = energy%kinetic + energy%elastic + energy%dissipated
    ! Volumes and density are 1; sums of 144 terms in another order differ by less than 144 epsilon.
    call assert(close_to(energy%kinetic, 0.5d0 * sum(velocity**2), 3d-14 * total), &
        'the kinetic energy is not the sum of 1/2 rho V v^2')
    call assert(close_to(energy%elastic, elastic, 3d-14 * total), &
        'the elastic energy is not the sum of its density')
    call assert(close_to(energy%dissipated, dissipated, 3d-14 * total), &
        'the dissipated energy is not the sum of its density')
    call assert(energy%dissipated > 0, 'nothing has broken')
    call assert(close_to(total - energy%external_work, energy%closure_error, 1d-14 * total), &
        'the closure error is not what the balance lacks')
    call simulation%destroy()
  end subroutine energies

  subroutine health_tells()
    integer :: pairs(2, 15), bonds, k
    type(perion_health) :: health
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%health(health)
    call simulation%bond_count(bonds)
    call assert(health%bonds == bonds .and. health%broken_bonds == 0, 'the bonds differ')
    call assert(health%isolated_points == 0 .and. health%first_isolated_point == 0, &
        'a point is isolated')
    call assert(health%detached_points == 0 .and. health%first_detached_point == 0, &
        'a point is detached')
    call assert(abs(health%time_step_ratio) <= 0, 'a step was made')

    ! The last point has neighbours in the last 4 rows and columns alone.
    pairs(1, :) = plate_count
    do k = 1, 15
      pairs(2, k) = plate_count - k / 4 * columns - mod(k, 4)
    end do
    call simulation%break_bonds(pairs)
    call simulation%health(health)
    call assert(health%detached_points == 1 .and. health%first_detached_point == plate_count, &
        'the last point is not detached')
    ! Offsets within a quarter circle of radius 3.015, both axes included.
    call assert(health%broken_bonds == 10, 'the corner has not had 10 bonds')
    call simulation%destroy()

    call points%create(reshape([0d0, 0d0, 9d0, 9d0, 1d0, 0d0], [2, 3]), [1d0, 1d0, 1d0])
    call make_model(model, brittle=.false.)
    call simulation%create(points, model)
    call simulation%health(health)
    call assert(health%isolated_points == 1 .and. health%first_isolated_point == 2, &
        'the second point is not isolated')
    call simulation%destroy()
    call model%destroy()
    call points%destroy()
  end subroutine health_tells

  subroutine memory_adds_up()
    type(perion_memory) :: memory
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.true.)
    call simulation%memory(memory)
    call assert(memory%bonds == 0, 'there are bonds before set-up has ended')
    call simulation%evaluate()
    call simulation%memory(memory)
    call assert(memory%points > 0 .and. memory%bonds > 0 .and. memory%state > 0, 'a part is empty')
    call assert(memory%total == memory%points + memory%bonds + memory%state, 'the sum differs')
    call simulation%destroy()
  end subroutine memory_adds_up

  subroutine refused()
    type(perion_energy) :: energy
    type(perion_health) :: health
    type(perion_memory) :: memory
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    health%bonds = -7
    memory%total = -7
    energy%kinetic = -7
    call simulation%energy(energy, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_energy')
    call simulation%memory(memory, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_memory')
    call make_points(points)
    call make_model(model, brittle=.false.)
    call model%set('horizon', 0.5d0)
    call simulation%create(points, model)
    call simulation%health(health, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'horizon')
    call assert(same_bits(energy%kinetic, -7d0) .and. health%bonds == -7 .and. memory%total == -7, &
        'a refused call has written its output')
    call simulation%destroy()
    call model%destroy()
    call points%destroy()
  end subroutine refused

end module balance_tests
