!> Energy, health and memory: structs that the host makes and the library fills.
module balance_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_balance

  character(*), parameter :: file = 'balance.f90'

contains

  subroutine test_balance()
    call run(file, 'energies are the sums of their densities and balance the work', energies)
    call run(file, 'health tells broken bonds and detached points', health_tells)
    call run(file, 'memory is the sum of its parts', memory_adds_up)
    call run(file, 'a struct without its size is refused, a shorter one filled as far', sizes)
  end subroutine test_balance

  subroutine energies()
    real(c_double) :: velocity(2, plate_count), elastic(1), dissipated(1), total
    type(perion_energy) :: energy
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call perion_energy_init(energy, c_sizeof(energy))
    call assert_ok(perion_simulation_energy(simulation, energy))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, velocity, 2 * plate_count))
    call assert_ok(perion_simulation_sum(simulation, PERION_FIELD_STRAIN_ENERGY_DENSITY, &
        components=elastic))
    call assert_ok(perion_simulation_sum(simulation, PERION_FIELD_DISSIPATED_ENERGY_DENSITY, &
        components=dissipated))
    total = energy%kinetic + energy%elastic + energy%dissipated
    ! Volumes and density are 1; sums of 144 terms in another order differ by less than 144 epsilon.
    call assert(close_to(energy%kinetic, 0.5_c_double * sum(velocity**2), 3e-14_c_double * total), &
        'the kinetic energy is not the sum of 1/2 rho V v^2')
    call assert(close_to(energy%elastic, elastic(1), 3e-14_c_double * total), &
        'the elastic energy is not the sum of its density')
    call assert(close_to(energy%dissipated, dissipated(1), 3e-14_c_double * total), &
        'the dissipated energy is not the sum of its density')
    call assert(energy%dissipated > 0, 'nothing has broken')
    call assert(close_to(total - energy%external_work, energy%closure_error, &
        1e-14_c_double * total), 'the closure error is not what the balance lacks')
    call destroy(simulation)
  end subroutine energies

  subroutine health_tells()
    integer(c_int64_t) :: pairs(2, columns), bonds, k
    type(perion_health) :: health
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call perion_health_init(health, c_sizeof(health))
    call assert_ok(perion_simulation_health(simulation, health))
    call assert_ok(perion_simulation_bond_count(simulation, bonds))
    call assert(health%bonds == bonds .and. health%broken_bonds == 0, 'the bonds differ')
    call assert(health%isolated_points == 0 .and. health%first_isolated_point == -1, &
        'a point is isolated')
    call assert(health%detached_points == 0 .and. health%first_detached_point == -1, &
        'a point is detached')
    call assert(abs(health%time_step_ratio) <= 0, 'a step was made')

    ! The first point has neighbours in rows 1 to 4 and columns 1 to 4 alone.
    do k = 0, 3
      pairs(1, 4 * k + 1:4 * k + 4) = 0
      pairs(2, 4 * k + 1:4 * k + 4) = columns * k + [0, 1, 2, 3]
    end do
    call assert_ok(perion_simulation_break_bonds(simulation, 15_c_int64_t, pairs(:, 2:)))
    call assert_ok(perion_simulation_health(simulation, health))
    call assert(health%detached_points == 1 .and. health%first_detached_point == 0, &
        'the first point is not detached')
    ! Offsets within a quarter circle of radius 3.015, both axes included.
    call assert(health%broken_bonds == 10, 'the corner has not had 10 bonds')
    call destroy(simulation)
  end subroutine health_tells

  subroutine memory_adds_up()
    type(perion_memory) :: memory
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call perion_memory_init(memory, c_sizeof(memory))
    call assert_ok(perion_simulation_memory(simulation, memory))
    call assert(memory%bonds == 0, 'there are bonds before set-up has ended')
    call assert_ok(perion_simulation_evaluate(simulation))
    call assert_ok(perion_simulation_memory(simulation, memory))
    call assert(memory%points > 0 .and. memory%bonds > 0 .and. memory%state > 0, 'a part is empty')
    call assert(memory%total == memory%points + memory%bonds + memory%state, 'the sum differs')
    call destroy(simulation)
  end subroutine memory_adds_up

  subroutine sizes()
    type(perion_energy) :: energy
    type(perion_health) :: health
    type(perion_memory) :: memory
    type(c_ptr) :: simulation

    call perion_energy_init(energy, c_sizeof(energy))
    call perion_health_init(health, c_sizeof(health))
    call perion_memory_init(memory, c_sizeof(memory))
    call assert(energy%struct_size == c_sizeof(energy), 'the size of perion_energy differs')
    call assert(health%struct_size == c_sizeof(health), 'the size of perion_health differs')
    call assert(memory%struct_size == c_sizeof(memory), 'the size of perion_memory differs')

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    energy%struct_size = 0
    call assert_refused(perion_simulation_energy(simulation, energy), PERION_ERROR_ARGUMENT, &
        'struct_size')
    ! A program of a time when the struct ended with `kinetic`.
    energy%struct_size = 16
    energy%kinetic = -1
    energy%elastic = -1
    call assert_ok(perion_simulation_energy(simulation, energy))
    call assert(abs(energy%kinetic) <= 0, 'the plate is at rest')
    call assert(same_bits(energy%elastic, -1.0_c_double), 'the library wrote beyond the struct')
    call destroy(simulation)
  end subroutine sizes

end module balance_tests
