# Installs BUILD and moves the copy to PREFIX, since it must not depend on where it was installed.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${PREFIX} ${PREFIX}.first)
run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${PREFIX}.first)
file(RENAME ${PREFIX}.first ${PREFIX})
