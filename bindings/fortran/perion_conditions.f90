!> Simulations: conditions, and what stands between the library's callbacks and the host's objects.
submodule (perion) conditions_procedures
  use, intrinsic :: iso_c_binding
  use perion_c, only: perion_simulation_prescribe, perion_simulation_prescribe_function, &
      perion_simulation_prescribe_table, perion_simulation_prescribe_values, &
      perion_simulation_release, perion_simulation_set_log, perion_simulation_set_progress
  use perion_support
  implicit none

contains

  module procedure prescribe_int64
    integer(c_int32_t) :: place

    if (.not. has_axis(self, 'perion_simulation_prescribe', axis, place, error)) return
    if (ok(perion_simulation_prescribe(self%handle, c_text(set), quantity, place, value), error)) &
        call forget_function(self, set, quantity, place)
  end procedure prescribe_int64

  module procedure prescribe_int32
    call prescribe_int64(self, set, quantity, int(axis, c_int64_t), value, error)
  end procedure prescribe_int32

  module procedure prescribe_vector
    character(*), parameter :: call = 'perion_simulation_prescribe'
    integer(c_int64_t), parameter :: exponent = int(z'7ff0000000000000', c_int64_t)
    integer(c_int64_t) :: axis, count

    if (.not. is_live(self%handle, call, error)) return
    count = size(values, kind=c_int64_t)
    if (count /= self%axes) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''values'' has ' // number(count) // &
          ' numbers; there must be one for each of ' // number(self%axes) // ' axes', error)
      return
    end if
    ! All of them first, or an axis would have its value when the next one is refused. By bits: no
    ! trap fires, and compilers that think all numbers finite do not think this away.
    do axis = 1, count
      if (iand(transfer(values(axis), exponent), exponent) /= exponent) cycle
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''values'' has a number for axis ' // &
          number(axis) // ' that is not finite', error)
      return
    end do
    do axis = 1, count
      call prescribe_int64(self, set, quantity, axis, values(axis), error)
      if (.not. present(error)) cycle
      if (allocated(error)) return
    end do
  end procedure prescribe_vector

  module procedure prescribe_table_int64
    character(*), parameter :: call = 'perion_simulation_prescribe_table'
    real(c_double), allocatable, target :: times_copy(:), values_copy(:)
    real(c_double), pointer, contiguous :: all_times(:), all_values(:)
    integer(c_int64_t) :: count
    integer(c_int32_t) :: place

    if (.not. has_axis(self, call, axis, place, error)) return
    count = size(times, kind=c_int64_t)
    if (size(values, kind=c_int64_t) /= count) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''times'' has ' // number(count) // &
          ' numbers and ''values'' ' // number(size(values, kind=c_int64_t)) // &
          '; there must be as many of both', error)
      return
    end if
    if (.not. lined_up(times, times_copy, all_times, call, error)) return
    if (.not. lined_up(values, values_copy, all_values, call, error)) return
    if (ok(perion_simulation_prescribe_table(self%handle, c_text(set), quantity, place, count, &
        all_times, all_values), error)) call forget_function(self, set, quantity, place)
  end procedure prescribe_table_int64

  module procedure prescribe_table_int32
    call prescribe_table_int64(self, set, quantity, int(axis, c_int64_t), times, values, error)
  end procedure prescribe_table_int32

  module procedure prescribe_function_int64
    character(*), parameter :: call = 'perion_simulation_prescribe_function'
    type(function_holder), pointer :: holder
    integer(c_int32_t) :: place
    integer :: flaw

    if (.not. has_axis(self, call, axis, place, error)) return
    allocate (holder, stat=flaw)
    if (.not. room(flaw, call, error)) return
    holder%host => function
    holder%dimension = self%axes
    holder%set = trim(set)
    holder%quantity = quantity
    holder%axis = place
    if (ok(perion_simulation_prescribe_function(self%handle, c_text(set), quantity, place, &
        c_funloc(ask_function), c_loc(holder)), error)) then
      call forget_function(self, set, quantity, place)
      holder%next => self%functions
      self%functions => holder
    else
      deallocate (holder)
    end if
  end procedure prescribe_function_int64

  module procedure prescribe_function_int32
    call prescribe_function_int64(self, set, quantity, int(axis, c_int64_t), function, error)
  end procedure prescribe_function_int32

  module procedure prescribe_values_int64
    character(*), parameter :: call = 'perion_simulation_prescribe_values'
    real(c_double), allocatable, target :: copy(:)
    real(c_double), pointer, contiguous :: each(:)
    integer(c_int32_t) :: place

    if (.not. has_axis(self, call, axis, place, error)) return
    if (.not. lined_up(values, copy, each, call, error)) return
    if (ok(perion_simulation_prescribe_values(self%handle, c_text(set), quantity, place, &
        size(values, kind=c_int64_t), each), error)) &
        call forget_function(self, set, quantity, place)
  end procedure prescribe_values_int64

  module procedure prescribe_values_int32
    call prescribe_values_int64(self, set, quantity, int(axis, c_int64_t), values, error)
  end procedure prescribe_values_int32

  module procedure release_int64
    integer(c_int32_t) :: place

    if (.not. has_axis(self, 'perion_simulation_release', axis, place, error)) return
    if (ok(perion_simulation_release(self%handle, c_text(set), quantity, place), error)) &
        call forget_function(self, set, quantity, place)
  end procedure release_int64

  module procedure release_int32
    call release_int64(self, set, quantity, int(axis, c_int64_t), error)
  end procedure release_int32

  !> The place of an axis, from 0, where there is a simulation with such an axis.
  recursive function has_axis(self, call, axis, place, error)
    class(perion_simulation), intent(in) :: self
    character(*), intent(in) :: call
    integer(c_int64_t), intent(in) :: axis
    integer(c_int32_t), intent(out) :: place
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: has_axis

    place = 0
    has_axis = is_live(self%handle, call, error)
    if (.not. has_axis) return
    has_axis = axis >= 1 .and. axis <= self%axes
    if (has_axis) then
      place = int(axis - 1, c_int32_t)
    else
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''axis'' is ' // number(axis) // &
          '; axes are 1 to ' // number(self%axes), error)
    end if
  end function has_axis

  !> Frees the holder of a function that the library asks no more.
  recursive subroutine forget_function(self, set, quantity, axis)
    class(perion_simulation), intent(inout) :: self
    character(*), intent(in) :: set
    integer(c_int32_t), intent(in) :: quantity, axis
    type(function_holder), pointer :: holder, previous

    previous => null()
    holder => self%functions
    do while (associated(holder))
      if (holder%set == set .and. holder%quantity == quantity .and. holder%axis == axis) then
        if (associated(previous)) then
          previous%next => holder%next
        else
          self%functions => holder%next
        end if
        deallocate (holder)
        return
      end if
      previous => holder
      holder => holder%next
    end do
  end subroutine forget_function

  recursive function ask_function(user, time, count, reference_positions, values) bind(c, name='') &
      result(stop_now)
    type(c_ptr), value :: user
    real(c_double), value :: time
    integer(c_int64_t), value :: count
    real(c_double), target, intent(in) :: reference_positions(*)
    real(c_double), intent(inout) :: values(*)
    integer(c_int) :: stop_now
    type(function_holder), pointer :: holder
    real(c_double), pointer, contiguous :: positions(:, :)
    logical :: stop

    call c_f_pointer(user, holder)
    call c_f_pointer(c_loc(reference_positions), positions, [holder%dimension, count])
    stop = .false.
    call holder%host%evaluate(time, positions, values(:count), stop)
    stop_now = merge(1_c_int, 0_c_int, stop)
  end function ask_function

  module procedure simulation_set_progress
    character(*), parameter :: call = 'perion_simulation_set_progress'
    type(progress_holder), pointer :: holder
    integer :: flaw

    if (.not. present(progress)) then
      if (.not. ok(perion_simulation_set_progress(self%handle, c_null_funptr, c_null_ptr), error)) return
      holder => null()
    else
      allocate (holder, stat=flaw)
      if (.not. room(flaw, call, error)) return
      holder%host => progress
      holder%simulation = self%handle
      holder%dimension = self%axes
      holder%count = self%points
      if (.not. ok(perion_simulation_set_progress(self%handle, c_funloc(tell_progress), &
          c_loc(holder)), error)) then
        deallocate (holder)
        return
      end if
    end if
    if (associated(self%progress)) deallocate (self%progress)
    self%progress => holder
  end procedure simulation_set_progress

  recursive function tell_progress(user, done, total, time) bind(c, name='') result(stop_now)
    type(c_ptr), value :: user
    integer(c_int64_t), value :: done, total
    real(c_double), value :: time
    integer(c_int) :: stop_now
    type(progress_holder), pointer :: holder
    type(perion_simulation) :: lent
    logical :: stop

    call c_f_pointer(user, holder)
    lent%handle = holder%simulation
    lent%axes = holder%dimension
    lent%points = holder%count
    stop = .false.
    call holder%host%report(lent, done, total, time, stop)
    ! It was lent: its end must not destroy the simulation.
    lent%handle = c_null_ptr
    stop_now = merge(1_c_int, 0_c_int, stop)
  end function tell_progress

  module procedure simulation_set_log
    character(*), parameter :: call = 'perion_simulation_set_log'
    type(log_holder), pointer :: holder
    integer :: flaw

    if (.not. present(log)) then
      if (.not. ok(perion_simulation_set_log(self%handle, c_null_funptr, c_null_ptr), error)) return
      holder => null()
    else
      allocate (holder, stat=flaw)
      if (.not. room(flaw, call, error)) return
      holder%host => log
      if (.not. ok(perion_simulation_set_log(self%handle, c_funloc(pass_message), c_loc(holder)), &
          error)) then
        deallocate (holder)
        return
      end if
    end if
    if (associated(self%log)) deallocate (self%log)
    self%log => holder
  end procedure simulation_set_log

  recursive subroutine pass_message(user, level, message) bind(c, name='')
    type(c_ptr), value :: user
    integer(c_int32_t), value :: level
    character(kind=c_char), target, intent(in) :: message(*)
    type(log_holder), pointer :: holder

    call c_f_pointer(user, holder)
    call holder%host%take(level, told(f_text(c_loc(message))))
  end subroutine pass_message

end submodule conditions_procedures
