# Flags of every target: strict warnings, and floating point with the same bits on every machine.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)

add_library(stator_flags INTERFACE)
target_compile_options(stator_flags INTERFACE
    ${STATOR_OPTIMIZE}
    -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Werror
    -ffp-contract=off -fno-math-errno
    -fno-exceptions -fno-rtti -fno-threadsafe-statics
)
target_compile_definitions(stator_flags INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MPL2_ONLY EIGEN_NO_IO)
get_target_property(eigen_folder Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
target_include_directories(stator_flags SYSTEM INTERFACE ${eigen_folder})
if(STATOR_SANITIZE)
    target_compile_options(stator_flags INTERFACE
        -fsanitize=${STATOR_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(stator_flags INTERFACE -fsanitize=${STATOR_SANITIZE})
endif()
