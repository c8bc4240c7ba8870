function is_there() result(yes)
  use perion_c
  implicit none
  logical :: yes
  yes = PERION_OK == 0
end function is_there
