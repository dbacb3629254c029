# Python classes of Baxter's messages, so that rostopic echo, rosbag and rospy know them where Rethink's package is not
# installed. Only Python's: the generator for a whole package works for the package's own project alone.

find_package(baxter_core_msgs QUIET)
if(baxter_core_msgs_FOUND OR baxter_core_msgs_SOURCE_DIR)
  return()
endif()

file(GLOB baxter_messages "${CHECKOUT}/msg/baxter_core_msgs/msg/*.msg")
set(include_flags -Ibaxter_core_msgs:${CHECKOUT}/msg/baxter_core_msgs/msg)
foreach(package geometry_msgs std_msgs)
  foreach(folder ${${package}_MSG_INCLUDE_DIRS})
    list(APPEND include_flags -I${package}:${folder})
  endforeach()
endforeach()

set(python_package "${CATKIN_DEVEL_PREFIX}/${PYTHON_INSTALL_DIR}/baxter_core_msgs")
set(ALL_GEN_OUTPUT_FILES_py "")
foreach(message ${baxter_messages})
  _generate_msg_py(baxter_core_msgs "${message}" "${include_flags}" "" "${python_package}")
endforeach()
_generate_module_py(baxter_core_msgs "${python_package}" "${ALL_GEN_OUTPUT_FILES_py}")
add_custom_target(${PROJECT_NAME}_baxter_core_msgs ALL DEPENDS ${ALL_GEN_OUTPUT_FILES_py})

install(DIRECTORY "${python_package}" DESTINATION "${PYTHON_INSTALL_DIR}" PATTERN __pycache__ EXCLUDE)
