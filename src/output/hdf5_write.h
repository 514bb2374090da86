/* hdf5_write.h: declares functions that write datasets and attributes of an HDF5 file, each in one call;
   numbers little endian. Each returns 0, or -1 on failure. */
#pragma once
#include "output/output.h"
#include <hdf5.h>

int Hdf5WriteReals(hid_t group, const char *name, int rank, const hsize_t *dims, const PetscReal *data);
/* Writes a member of an array of structs: dims[0] rows that are `row` bytes apart, each of dims[1] parts that
   are `part` bytes apart, each of dims[2] reals. first: the member in the first row. */
int Hdf5WriteMember(hid_t group, const char *name, int rank, const hsize_t *dims, const void *first,
                    size_t row, size_t part);
int Hdf5WriteInts(hid_t group, const char *name, hsize_t rows, hsize_t columns, const PetscInt *data);
int Hdf5WriteNames(hid_t group, const char *name, PetscInt n, char (*names)[NAME_LENGTH]);
int Hdf5WriteAttribute(hid_t where, const char *name, hid_t type, hid_t memory_type, const void *value);
int Hdf5WriteText(hid_t where, const char *name, const char *text);
int Hdf5WriteNumber(hid_t where, const char *name, double value);
int Hdf5WriteCount(hid_t where, const char *name, long long value);

/* ---- results_tables.c */
/* Writes fields->tables and the shapes of modes below the group of a stage; returns 0 or -1. */
int ResultsTablesWrite(hid_t stage, const Scene *scene, PetscInt n_vertices, const StageFields *fields);
/* Writes the envelopes, if there are any, below the group of a stage; returns 0 or -1. */
int ResultsEnvelopeWrite(hid_t stage, PetscInt n_blocks, const StageFields *fields);
