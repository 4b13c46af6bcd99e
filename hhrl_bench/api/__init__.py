"""What Python code calls: agents scored and compared in a line each, the results to print, watch and export."""
