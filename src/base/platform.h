#pragma once
// Everything that is tied to an operating system. platform_posix.cpp is the only implementation so far; another system adds a
// file beside it and nothing else changes.
#include <cstdint>
#include <filesystem>
#include <string>

namespace parhelion::platform {

// Ctrl-C and SIGTERM set a flag instead of ending the process; long work polls it. The second signal ends the process at once.
void install_interrupt_handlers();
enum class Interrupt { None, Interrupted, Terminated };
Interrupt interrupt_requested();
void set_interrupt(Interrupt value);  // tests, embedding programs

bool is_terminal(int file_descriptor);  // 1 stdout, 2 stderr
unsigned terminal_width();
uint64_t process_id();
bool process_exists(uint64_t process);
uint64_t resident_bytes();  // memory this process holds now
uint64_t peak_resident_bytes();
std::filesystem::path cache_folder();  // PARHELION_CACHE_DIR, else the user's cache folder / parhelion

// Flushes a file's data to the disk; false if that failed (disk full shows up here).
bool sync_file(const std::filesystem::path& path);

// A shared library loaded at run time; nullptr if it is not there.
void* load_library(const std::string& name);
void* library_symbol(void* library, const char* name);

}  // namespace parhelion::platform
