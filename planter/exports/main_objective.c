static int objective(void)
{
  static const char *const names[] = {$names};
  ${name}_found found;
  double gradient[$design_size];
  const int status = ${name}_gradient(&memory, ${name}_design, ${name}_machine, &found, gradient);
  if (status) return fail(status);
  printf("$formats", $numbers);
  for (int i = 0; i < ${NAME}_PARAMETERS; ++i) printf("gradient.%s %.17g\n", names[i], gradient[i]);
  return 0;
}
