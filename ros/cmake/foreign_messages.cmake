# Python classes of other packages' messages, so that rostopic echo, rosbag and rospy know them where those packages are
# not installed. Only Python's: the generator for a whole package works for the package's own project alone.
#
# add_foreign_messages(PACKAGE [DEPENDENCY...]): from msg/PACKAGE/msg in the checkout. FOREIGN_MESSAGES lists the targets.
function(add_foreign_messages package)
  find_package(${package} QUIET)
  if(${package}_FOUND OR ${package}_SOURCE_DIR)
    return()
  endif()

  set(definitions "${CHECKOUT}/msg/${package}/msg")
  file(GLOB messages "${definitions}/*.msg")
  set(include_flags -I${package}:${definitions})
  foreach(dependency ${ARGN})
    foreach(folder ${${dependency}_MSG_INCLUDE_DIRS})
      list(APPEND include_flags -I${dependency}:${folder})
    endforeach()
  endforeach()

  set(python_package "${CATKIN_DEVEL_PREFIX}/${PYTHON_INSTALL_DIR}/${package}")
  set(ALL_GEN_OUTPUT_FILES_py "")
  foreach(message ${messages})
    _generate_msg_py(${package} "${message}" "${include_flags}" "" "${python_package}")
  endforeach()
  _generate_module_py(${package} "${python_package}" "${ALL_GEN_OUTPUT_FILES_py}")
  add_custom_target(${PROJECT_NAME}_${package} ALL DEPENDS ${ALL_GEN_OUTPUT_FILES_py})
  set(FOREIGN_MESSAGES ${FOREIGN_MESSAGES} ${PROJECT_NAME}_${package} PARENT_SCOPE)

  install(DIRECTORY "${python_package}" DESTINATION "${PYTHON_INSTALL_DIR}" PATTERN __pycache__ EXCLUDE)
endfunction()
