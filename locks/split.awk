# Reads a lock; prints it without torch and the libraries that torch's CUDA build needs, and writes those to the file `torch`.
/^[a-z]/ { kept = !/^(torch==|triton==|cuda-|nvidia-)/ }
kept { print }
!kept { print > torch }
