#!/bin/bash
#SBATCH --job-name=@name@-merge
@account@#SBATCH --time=60
#SBATCH --mem=4000M
#SBATCH --output=@log@

set -e
@program@ batch merge --out @out@ @out@
@program@ report @out@
