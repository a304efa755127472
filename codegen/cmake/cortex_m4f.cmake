# Toolchain of the boards with a Cortex-M4F: Debian's gcc-arm-none-eabi.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m4f)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
# Eigen's package lies with the host's.
list(APPEND CMAKE_PREFIX_PATH /usr/local /usr)
# The whole image is optimised at once, in one part: the constants of topics reach the nodes. What
# fills a sample is inlined before, so that the ports of an activation stay in registers: image and
# activations get smaller.
set(CMAKE_CXX_FLAGS_INIT
    "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -flto=1 -flto-partition=one --param=early-inlining-insns=200 -g")
set(CMAKE_AR arm-none-eabi-gcc-ar)
set(CMAKE_RANLIB arm-none-eabi-gcc-ranlib)
# No _sbrk anywhere: whatever needs a heap does not link.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-nostartfiles --specs=nano.specs -Wl,--gc-sections -Wl,--fatal-warnings -Wl,--build-id=sha1 -Werror=odr")
