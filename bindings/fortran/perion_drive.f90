!> Simulations: driven, asked for their balance, written to files.
submodule (perion) drive_procedures
  use, intrinsic :: iso_c_binding, only: c_sizeof
  use perion_c, only: perion_advance_options_init, perion_energy_init, perion_health_init, &
      perion_memory_init, perion_report_init, perion_simulation_advance, &
      perion_simulation_commit, perion_simulation_energy, perion_simulation_evaluate, &
      perion_simulation_health, perion_simulation_memory, perion_simulation_set_time, &
      perion_simulation_stable_time_step, perion_simulation_step, perion_simulation_step_count, &
      perion_simulation_time, perion_simulation_write_series, perion_simulation_write_vtk, &
      raw_energy => perion_energy, raw_health => perion_health, raw_memory => perion_memory, &
      raw_options => perion_advance_options, raw_report => perion_report
  use perion_support, only: c_text, check, narrow, ok
  implicit none

contains

  module procedure simulation_evaluate
    call check(perion_simulation_evaluate(self%handle), error)
  end procedure simulation_evaluate

  module procedure simulation_commit
    call check(perion_simulation_commit(self%handle, time_step), error)
  end procedure simulation_commit

  module procedure simulation_stable_time_step
    call check(perion_simulation_stable_time_step(self%handle, time_step), error)
  end procedure simulation_stable_time_step

  module procedure step_int64
    call check(perion_simulation_step(self%handle, time_step, steps), error)
  end procedure step_int64

  module procedure step_int32
    call check(perion_simulation_step(self%handle, time_step, int(steps, c_int64_t)), error)
  end procedure step_int32

  module procedure simulation_advance
    type(raw_options) :: asked
    type(raw_report) :: told
    integer(c_int32_t) :: status

    call perion_advance_options_init(asked, c_sizeof(asked))
    call perion_report_init(told, c_sizeof(told))
    if (present(options)) then
      asked%safety = options%safety
      asked%largest_time_step = options%largest_time_step
      asked%interval = options%interval
    end if
    told%steps = -1
    status = perion_simulation_advance(self%handle, until, asked, told)
    ! A call that was refused has left it as it was.
    if (present(report) .and. told%steps >= 0) then
      report%steps = told%steps
      report%estimates = told%estimates
      report%smallest_time_step = told%smallest_time_step
      report%largest_time_step = told%largest_time_step
      report%stable_time_step = told%stable_time_step
      report%time = told%time
    end if
    call check(status, error)
  end procedure simulation_advance

  module procedure simulation_time
    call check(perion_simulation_time(self%handle, time), error)
  end procedure simulation_time

  module procedure simulation_set_time
    call check(perion_simulation_set_time(self%handle, time), error)
  end procedure simulation_set_time

  module procedure step_count_int64
    call check(perion_simulation_step_count(self%handle, count), error)
  end procedure step_count_int64

  module procedure step_count_int32
    integer(c_int64_t) :: wide

    if (ok(perion_simulation_step_count(self%handle, wide), error)) then
      call narrow('perion_simulation_step_count', wide, count, error)
    end if
  end procedure step_count_int32

  module procedure simulation_energy
    type(raw_energy) :: told

    call perion_energy_init(told, c_sizeof(told))
    if (.not. ok(perion_simulation_energy(self%handle, told), error)) return
    energy%kinetic = told%kinetic
    energy%elastic = told%elastic
    energy%dissipated = told%dissipated
    energy%external_work = told%external_work
    energy%closure_error = told%closure_error
    energy%plastic = told%plastic
  end procedure simulation_energy

  module procedure simulation_health
    type(raw_health) :: told

    call perion_health_init(told, c_sizeof(told))
    if (.not. ok(perion_simulation_health(self%handle, told), error)) return
    health%isolated_points = told%isolated_points
    health%first_isolated_point = told%first_isolated_point + 1
    health%detached_points = told%detached_points
    health%first_detached_point = told%first_detached_point + 1
    health%degenerate_points = told%degenerate_points
    health%first_degenerate_point = told%first_degenerate_point + 1
    health%bonds = told%bonds
    health%broken_bonds = told%broken_bonds
    health%time_step_ratio = told%time_step_ratio
    health%smallest_stretch = told%smallest_stretch
    health%stable_time_step = told%stable_time_step
    health%stable_step_is_guaranteed = told%stable_step_is_guaranteed
  end procedure simulation_health

  module procedure simulation_memory
    type(raw_memory) :: told

    call perion_memory_init(told, c_sizeof(told))
    if (.not. ok(perion_simulation_memory(self%handle, told), error)) return
    memory%points = told%points
    memory%bonds = told%bonds
    memory%state = told%state
    memory%total = told%total
  end procedure simulation_memory

  module procedure simulation_write_vtk
    if (present(fields)) then
      call check(perion_simulation_write_vtk(self%handle, c_text(path), &
          size(fields, kind=c_int64_t), fields), error)
    else
      call check(perion_simulation_write_vtk(self%handle, c_text(path), 0_c_int64_t, &
          [integer(c_int32_t) ::]), error)
    end if
  end procedure simulation_write_vtk

  module procedure simulation_write_series
    if (present(fields)) then
      call check(perion_simulation_write_series(self%handle, c_text(pvd_path), &
          size(fields, kind=c_int64_t), fields), error)
    else
      call check(perion_simulation_write_series(self%handle, c_text(pvd_path), 0_c_int64_t, &
          [integer(c_int32_t) ::]), error)
    end if
  end procedure simulation_write_series

end submodule drive_procedures
