# Toolchain of a cross build for aarch64 on Debian, whose programs run under qemu (scripts/check_platforms aarch64).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)  # GCC 10 changed how pairs are passed; nothing here is older
