# perion_fortran(DIRECTORY SOURCES PROBLEM): makes perion::Fortran from the sources, as a library of the host's own
# build: what one Fortran compiler writes about a module, another one, or another version of it, cannot read.
# PROBLEM is empty, or says why it cannot be made. A library that is to be exported takes the sources themselves:
# target_sources(yours PRIVATE ${perion_FORTRAN_SOURCES}), and perion::perion.
function(perion_fortran directory sources problem)
  set(${problem} "" PARENT_SCOPE)
  get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  if(NOT "Fortran" IN_LIST languages)
    set(${problem} "the component Fortran needs Fortran among the languages of your project(), \
such as project(name LANGUAGES C Fortran)" PARENT_SCOPE)
    return()
  endif()
  separate_arguments(sources UNIX_COMMAND "${sources}")
  list(TRANSFORM sources PREPEND "${directory}/")
  set(perion_FORTRAN_SOURCES "${sources}" PARENT_SCOPE)
  if(TARGET perion::Fortran)
    return()
  endif()
  set(modules "${CMAKE_CURRENT_BINARY_DIR}/perion_modules")
  add_library(perion_fortran STATIC EXCLUDE_FROM_ALL ${sources})
  set_target_properties(perion_fortran PROPERTIES
    Fortran_FORMAT FREE
    Fortran_MODULE_DIRECTORY "${modules}"
    POSITION_INDEPENDENT_CODE ON)
  target_include_directories(perion_fortran INTERFACE "${modules}")
  target_link_libraries(perion_fortran PUBLIC perion::perion)
  add_library(perion::Fortran ALIAS perion_fortran)
endfunction()
