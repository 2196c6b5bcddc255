# Included by `project`: makes find_package fatal.
macro(find_package name)
    message(FATAL_ERROR "find_package(${name}) was called")
endmacro()
