# Flags of every target: strict warnings, and floating point with the same bits on every machine.
# Not by way of PATH, or of a registry in the home folder: neither is part of the build's key.
find_package(Eigen3 3.4 REQUIRED NO_MODULE NO_SYSTEM_ENVIRONMENT_PATH NO_CMAKE_PACKAGE_REGISTRY)

add_library(stator_flags INTERFACE)
target_compile_options(stator_flags INTERFACE
    $<IF:$<BOOL:$<TARGET_PROPERTY:STATOR_OPTIMIZE>>,$<TARGET_PROPERTY:STATOR_OPTIMIZE>,${STATOR_OPTIMIZE}>
    -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Werror
    -ffp-contract=off -fno-math-errno
    -fno-exceptions -fno-rtti -fno-threadsafe-statics
)
target_compile_definitions(stator_flags INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MPL2_ONLY EIGEN_NO_IO EIGEN_NO_DEBUG)
get_target_property(eigen_folder Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
target_include_directories(stator_flags SYSTEM INTERFACE ${eigen_folder})
# Lines, for the report of a crash; variables as well for a debugger. An image has them in any case.
if(STATOR_DEBUG)
    target_compile_options(stator_flags INTERFACE -O0 -g)
elseif(NOT CMAKE_SYSTEM_NAME STREQUAL "Generic")
    target_compile_options(stator_flags INTERFACE -g1)
endif()
# gcc compares definitions of one name where it optimises a whole program. Unoptimised, nothing is
# inlined before it looks.
if(STATOR_ODR)
    set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
    target_compile_options(stator_flags INTERFACE -O0)
    target_link_options(stator_flags INTERFACE -Wodr -Werror=odr -Werror=lto-type-mismatch)
endif()
if(STATOR_SANITIZE)
    target_compile_options(stator_flags INTERFACE
        -fsanitize=${STATOR_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
        -Wno-error)  # gcc warns of what the sanitizers insert
    target_link_options(stator_flags INTERFACE -fsanitize=${STATOR_SANITIZE})
endif()

# stator_precompile(TARGET [TEST] [SMALL]): Eigen's headers, and those of tests, take most of a compilation, so
# they are compiled once. They see no option of a graph, a board or an executor: all build folders
# share them, by ccache. A folder of tests with other flags sets STATOR_PRECOMPILED to a name of its
# own. The runtime, the world and clang-tidy compile without, so that a missing include shows.
# The code of tests is optimised less, because it takes longer to compile than to run. What is small
# is optimised for size.
set(STATOR_PRECOMPILED stator_precompiled)
function(stator_precompile target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "TEST;SMALL" "" "")
    set(name ${STATOR_PRECOMPILED})
    set(headers <Eigen/Core> <Eigen/Geometry>)
    if(arg_TEST)
        string(APPEND name _test)
        set_target_properties(${target} PROPERTIES STATOR_OPTIMIZE -O1)
        list(APPEND headers <gtest/gtest.h>)
    endif()
    if(arg_SMALL)
        string(APPEND name _small)
        set_target_properties(${target} PROPERTIES STATOR_OPTIMIZE -Os)
    endif()
    if(NOT TARGET ${name})
        file(WRITE "${CMAKE_BINARY_DIR}/${name}.cpp" "")
        add_library(${name} OBJECT "${CMAKE_BINARY_DIR}/${name}.cpp")
        target_link_libraries(${name} PRIVATE stator_flags $<$<BOOL:${arg_TEST}>:GTest::gtest>)
        target_precompile_headers(${name} PRIVATE ${headers})
        if(arg_SMALL)
            set_target_properties(${name} PROPERTIES STATOR_OPTIMIZE -Os)
        endif()
    endif()
    target_precompile_headers(${target} REUSE_FROM ${name})
endfunction()
