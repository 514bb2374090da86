/* hdf5_disk.h: HDF5 files that are written, on a disk that may fail. */
#pragma once
#include "output/output.h"
#include <hdf5.h>

/* A new file, or an existing one to be changed; negative: no such file, or no right to. One at a time. */
hid_t DiskFileCreate(const char *path);
hid_t DiskFileOpen(const char *path);
/* Closes it, and writes length and CRC-32 of what is behind its first DISK_HEADER bytes into them. 0 when
   all of it is on the disk, else the errno of the first call of the system that failed. */
enum { DISK_HEADER = 512 };
int DiskFileClose(hid_t file);
/* Whether such a file is what was written; if not, errno says why it cannot be read, 0: it can. */
int DiskFileIsWhole(const char *path);
/* Such a file to be read, closed by H5Fclose; negative: it is not there, cannot be read
   (errno), or is not whole (errno is 0). A failure on the way
   is told by the DiskFileClose of the file that is written meanwhile. */
hid_t DiskFileRead(const char *path);
