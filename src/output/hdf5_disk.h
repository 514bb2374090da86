/* hdf5_disk.h: declares HDF5 files that are written safely, on a disk that may fail. */
#pragma once
#include "output/output.h"
#include <hdf5.h>

/* Creates a file, or opens an existing one to change it. Negative: no such file, or no right to. One file at
   a time. */
hid_t DiskFileCreate(const char *path);
hid_t DiskFileOpen(const char *path);
/* Closes the file, and writes length and CRC-32 of all bytes after its first DISK_HEADER bytes into these.
   Returns 0 when all of it is on the disk, else the errno of the first system call that failed. */
enum { DISK_HEADER = 512 };
int DiskFileClose(hid_t file);
/* Returns whether the file is as it was written. If not, errno says why it cannot be read; 0: it can be
   read. */
int DiskFileIsWhole(const char *path);
/* Opens such a file to read; close it by H5Fclose. Negative: the file is missing, cannot be read (errno), or
   is damaged (errno is 0). A later failure is reported by DiskFileClose of the file that is written
   meanwhile. */
hid_t DiskFileRead(const char *path);
