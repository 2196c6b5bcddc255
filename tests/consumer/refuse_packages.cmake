# Included by `project`: from here on nobody finds a package.
macro(find_package name)
    message(FATAL_ERROR "find_package(${name}) was called")
endmacro()
