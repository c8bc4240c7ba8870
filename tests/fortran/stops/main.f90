!> What must end the program with a text: the argument says which.
program stops
  use perion
  implicit none

  type :: body
    type(perion_model) :: model
  end type body

  type(perion_points) :: points, other_points
  type(perion_model) :: model, other_model
  type(perion_simulation) :: simulation, other_simulation
  type(body) :: one, other
  character(40) :: which

  call get_command_argument(1, which)
  call points%create_block([0d0, 0d0], [3d0, 3d0], 1d0)
  call model%create('bond_based')
  select case (which)
  case ('points')
    other_points = points
  case ('model')
    other_model = model
  case ('an empty model')
    model = other_model
  case ('simulation')
    other_simulation = simulation
  case ('part of a type')
    call other%model%create('bond_based')
    one = other
  case ('failure without error')
    call model%set('density', -1d0)
  case ('an object that was not created')
    call simulation%step(1d0, 1)
  end select
end program stops
