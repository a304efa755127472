// The same calls as on the board of the emulator.
#include "../../../../../boards/qemu_f405/semihosting.cpp"
