# Given to cmake as CMAKE_PROJECT_INCLUDE when msg_defs is built against ROS wheels.
#
# Targets that the wheels export name the Python headers of the image in which the wheels were
# made, and cmake refuses an imported target whose include directory does not exist. Once the
# project has been read, this takes such directories off the imported targets. Where all
# directories exist, as in an ordinary ROS installation, it does nothing.
# DEFER needs cmake 3.19, IMPORTED_TARGETS needs 3.21.

function(keep_existing_include_dirs target)
  get_target_property(listed ${target} INTERFACE_INCLUDE_DIRECTORIES)
  if(NOT listed)
    return()
  endif()
  set(existing)
  foreach(entry IN LISTS listed)
    string(GENEX_STRIP "${entry}" plain)
    if(NOT plain STREQUAL entry OR NOT IS_ABSOLUTE "${entry}" OR EXISTS "${entry}")
      list(APPEND existing "${entry}")
    endif()
  endforeach()
  set_property(TARGET ${target} PROPERTY INTERFACE_INCLUDE_DIRECTORIES "${existing}")
endfunction()

function(mend_imported_targets)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    keep_existing_include_dirs(${target})
  endforeach()
endfunction()

cmake_language(DEFER CALL mend_imported_targets)
