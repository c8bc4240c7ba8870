!> What must end the program with a text: the argument says which.
program stops
  use perion
  implicit none

  type :: body
    type(perion_model) :: model
  end type body

  type :: rods
    type(perion_model) :: models(2)
  end type rods

  type(perion_points) :: points, other_points, many_points(2), more_points(2)
  type(perion_model) :: model, other_model, many_models(2), more_models(2)
  type(perion_simulation) :: simulation, other_simulation, many_simulations(2), more_simulations(2)
  type(body) :: one, other, bodies(2), more_bodies(2)
  type(rods) :: some_rods, other_rods
  character(40) :: which

  call get_command_argument(1, which)
  call points%create_block([0d0, 0d0], [3d0, 3d0], 1d0)
  call model%create('bond_based')
  call model%set('density', 1d0)
  call model%set('youngs_modulus', 1d0)
  call model%set('horizon', 2d0)
  select case (which)
  case ('points')
    other_points = points
  case ('model')
    other_model = model
  case ('an empty model')
    model = other_model
  case ('simulation')
    call simulation%create(points, model)
    other_simulation = simulation
  case ('array of points')
    call many_points(2)%create_block([0d0, 0d0], [3d0, 3d0], 1d0)
    more_points = many_points
  case ('array of models')
    call many_models(1)%create('bond_based')
    more_models(2:) = many_models(:1)
  case ('array of simulations')
    call many_simulations(2)%create(points, model)
    more_simulations = many_simulations
  case ('points for an array')
    many_points = points
  case ('part of a type')
    call other%model%create('bond_based')
    one = other
  case ('part of an array of a type')
    call bodies(2)%model%create('bond_based')
    more_bodies = bodies
  case ('array in a type')
    call some_rods%models(2)%create('bond_based')
    other_rods = some_rods
  case ('failure without error')
    call model%set('density', -1d0)
  case ('an object that was not created')
    call simulation%step(1d0, 1)
  end select
end program stops
