# Flags of every target: strict warnings, and floating point with the same bits on every machine.
# Not by way of PATH, or of a registry in the home folder: neither is part of the build's key.
find_package(Eigen3 3.4 REQUIRED NO_MODULE NO_SYSTEM_ENVIRONMENT_PATH NO_CMAKE_PACKAGE_REGISTRY)

add_library(stator_flags INTERFACE)
target_compile_options(stator_flags INTERFACE
    ${STATOR_OPTIMIZE}
    -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Werror
    -ffp-contract=off -fno-math-errno
    -fno-exceptions -fno-rtti -fno-threadsafe-statics
)
target_compile_definitions(stator_flags INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MPL2_ONLY EIGEN_NO_IO EIGEN_NO_DEBUG)
if(STATOR_RECORDING)
    target_compile_definitions(stator_flags INTERFACE STATOR_RECORDING)
endif()
get_target_property(eigen_folder Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
target_include_directories(stator_flags SYSTEM INTERFACE ${eigen_folder})
# gcc compares definitions of one name where it optimises a whole program. Unoptimised, nothing is
# inlined before it looks.
if(STATOR_ODR)
    set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
    target_compile_options(stator_flags INTERFACE -O0)
    target_link_options(stator_flags INTERFACE -Wodr -Werror=odr -Werror=lto-type-mismatch)
endif()
if(STATOR_SANITIZE)
    target_compile_options(stator_flags INTERFACE
        -fsanitize=${STATOR_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(stator_flags INTERFACE -fsanitize=${STATOR_SANITIZE})
endif()

# Eigen's headers take most of a compilation, so they are compiled once. Tests compile without, so
# that a missing include shows.
function(stator_precompile_eigen target executor)
    if(NOT TARGET stator_eigen_${executor})
        file(WRITE "${CMAKE_BINARY_DIR}/stator_eigen_${executor}.cpp" "")
        add_library(stator_eigen_${executor} OBJECT "${CMAKE_BINARY_DIR}/stator_eigen_${executor}.cpp")
        target_link_libraries(stator_eigen_${executor} PRIVATE stator_flags stator_${executor})
        target_precompile_headers(stator_eigen_${executor} PRIVATE <Eigen/Core> <Eigen/Geometry>)
    endif()
    target_precompile_headers(${target} REUSE_FROM stator_eigen_${executor})
endfunction()
